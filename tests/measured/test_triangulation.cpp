// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "server/measured/triangulation.h"

namespace kiln {
namespace {

using measured::Triangulation;
using Points = std::vector<Triangulation::Point>;

double whole_area(const Triangulation& mesh) {
    double sum = 0;
    for (const std::uint32_t t : mesh.inner()) {
        EXPECT_GT(mesh.area(t), 0);
        sum += mesh.area(t);
    }
    return sum;
}

/// No node within any triangle's circle, by floating point with a margin for its rounding.
void expect_delaunay(const Triangulation& mesh) {
    for (const std::uint32_t t : mesh.inner()) {
        const auto& n = mesh.triangle(t).node;
        const auto a = mesh.position(n[0]), b = mesh.position(n[1]), c = mesh.position(n[2]);
        const double d = 2 * ((b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x));
        const double bb = (b.x - a.x) * (b.x - a.x) + (b.y - a.y) * (b.y - a.y);
        const double cc = (c.x - a.x) * (c.x - a.x) + (c.y - a.y) * (c.y - a.y);
        const double x = ((c.y - a.y) * bb - (b.y - a.y) * cc) / d;
        const double y = ((b.x - a.x) * cc - (c.x - a.x) * bb) / d;
        const double radius = std::hypot(x, y);
        for (std::uint32_t node = 3; node < mesh.node_count() + 3; ++node) {
            const auto p = mesh.position(node);
            ASSERT_GT(std::hypot(p.x - a.x - x, p.y - a.y - y), radius * (1 - 1e-6));
        }
    }
}

TEST(Triangulation, CirclesAreEmptyAndTheSquareIsCovered) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> place(-0.9, 0.9);
    Points points = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
    for (int n = 0; n < 300; ++n) points.push_back({place(random), place(random)});
    const Triangulation mesh(points);
    expect_delaunay(mesh);
    EXPECT_NEAR(whole_area(mesh), 4, 1e-12);
}

/// All points on circles about one centre and on rays from it: everything is degenerate.
TEST(Triangulation, PolarGridsAreWhole) {
    Points points;
    for (int ring = 0; ring <= 20; ++ring)
        for (int step = 0; step <= 72; ++step)
            points.push_back({ring / 20.0 * std::cos(step * M_PI / 36),
                              ring / 20.0 * std::sin(step * M_PI / 36)});
    const Triangulation mesh(points);
    EXPECT_EQ(mesh.node_count(), 20u * 72 + 1);  // the centre and the seam are one each
    // A polygon of 72 corners; rounding to 2^-24 moves its border by as much.
    EXPECT_NEAR(whole_area(mesh), 36 * std::sin(M_PI / 36), 1e-6);
}

TEST(Triangulation, PointsInALineHaveNoArea) {
    Points points;
    for (int n = 0; n < 50; ++n) points.push_back({n / 64.0, n / 128.0});
    EXPECT_TRUE(Triangulation(points).inner().empty());
    EXPECT_TRUE(Triangulation({}).inner().empty());
    EXPECT_TRUE(Triangulation({{0, 0}, {0, 0}}).inner().empty());
}

TEST(Triangulation, FindsEveryPlaceWithItsWeights) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> place(-1, 1);
    Points points;
    for (int n = 0; n < 200; ++n) points.push_back({place(random), place(random)});
    const Triangulation mesh(points);
    std::uint32_t hint = 0;
    int inside = 0;
    for (int n = 0; n < 500; ++n) {
        const double x = 0.8 * place(random), y = 0.8 * place(random);
        const auto found = mesh.locate({x, y}, hint);
        if (found.triangle == Triangulation::kNone) continue;
        ++inside;
        double sum = 0, px = 0, py = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            const auto p = mesh.position(mesh.triangle(found.triangle).node[k]);
            EXPECT_GE(found.weight[k], 0);
            sum += found.weight[k];
            px += found.weight[k] * p.x;
            py += found.weight[k] * p.y;
        }
        EXPECT_NEAR(sum, 1, 1e-12);
        EXPECT_NEAR(px, x, 1e-7);  // places are rounded to 2^-24
        EXPECT_NEAR(py, y, 1e-7);
    }
    EXPECT_GT(inside, 400);
}

TEST(Triangulation, OrderOfPointsChangesNoArea) {
    Points points;
    for (int y = 0; y < 30; ++y)
        for (int x = 0; x < 30; ++x) points.push_back({x / 32.0, y / 32.0});
    Points backwards(points.rbegin(), points.rend());
    EXPECT_DOUBLE_EQ(whole_area(Triangulation(points)), 29.0 * 29 / 1024);
    EXPECT_DOUBLE_EQ(whole_area(Triangulation(backwards)), 29.0 * 29 / 1024);
}

}  // namespace
}  // namespace kiln
