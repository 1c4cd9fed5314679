// SPDX-License-Identifier: Apache-2.0
#include "server/measured/triangulation.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numeric>

namespace kiln::measured {
namespace {

constexpr std::int64_t kUnit = std::int64_t{1} << 24;
/// The helpers lie this far out. Differences stay below 2^29, so their squares' sums below 2^59
/// and the terms of in_circle() below 2^119: within 128 bits.
constexpr std::int64_t kFar = std::int64_t{1} << 28;

// An extension of the language, which -Wpedantic alone would mind.
__extension__ typedef __int128 Wide;

/// Interleaved bits of two coordinates, so that neighbours are inserted after one another.
std::uint64_t morton(std::int64_t x, std::int64_t y) {
    const auto spread = [](std::uint64_t v) {
        v &= 0xffffffff;
        v = (v | v << 16) & 0x0000ffff0000ffff;
        v = (v | v << 8) & 0x00ff00ff00ff00ff;
        v = (v | v << 4) & 0x0f0f0f0f0f0f0f0f;
        v = (v | v << 2) & 0x3333333333333333;
        return (v | v << 1) & 0x5555555555555555;
    };
    return spread(static_cast<std::uint64_t>(x + kUnit)) |
           spread(static_cast<std::uint64_t>(y + kUnit)) << 1;
}

int next(int k) { return k == 2 ? 0 : k + 1; }
int before(int k) { return k == 0 ? 2 : k - 1; }

}  // namespace

Triangulation::Node Triangulation::rounded(Point at) {
    const auto whole = [](double v) {
        return static_cast<std::int64_t>(
            std::llround(std::clamp(v, -1.0, 1.0) * static_cast<double>(kUnit)));
    };
    return {whole(at.x), whole(at.y)};
}

Triangulation::Point Triangulation::position(std::uint32_t node) const {
    const Node& at = nodes_[node];
    return {static_cast<double>(at.x) / static_cast<double>(kUnit),
            static_cast<double>(at.y) / static_cast<double>(kUnit)};
}

Triangulation::Triangulation(const std::vector<Point>& points) {
    nodes_ = {{-kFar, -kFar}, {kFar, -kFar}, {0, kFar}};
    triangles_.push_back({{0, 1, 2}, {kNone, kNone, kNone}});
    node_of_.assign(points.size(), kNone);
    std::vector<Node> rounded_points;
    std::vector<std::uint64_t> key;
    for (const Point& at : points) {
        rounded_points.push_back(rounded(at));
        key.push_back(morton(rounded_points.back().x, rounded_points.back().y));
    }
    std::vector<std::uint32_t> order(points.size());
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
        return key[a] != key[b] ? key[a] < key[b] : a < b;
    });
    triangles_.reserve(2 * points.size() + 8);
    for (std::size_t n = 0; n < order.size(); ++n) {
        const std::uint32_t point = order[n];
        if (n > 0 && key[order[n - 1]] == key[point]) {  // equal keys are equal places
            node_of_[point] = node_of_[order[n - 1]];
            continue;
        }
        node_of_[point] = static_cast<std::uint32_t>(nodes_.size());
        nodes_.push_back(rounded_points[point]);
        insert(node_of_[point]);
    }
    find_starts();
}

std::size_t Triangulation::start_cell(const Node& at) const {
    const auto side = static_cast<std::int64_t>(start_side_);
    const auto cell = [side](std::int64_t v) {
        return static_cast<std::size_t>(
            std::clamp((v + kUnit) * side / (2 * kUnit), std::int64_t{0}, side - 1));
    };
    return cell(at.y) * start_side_ + cell(at.x);
}

void Triangulation::find_starts() {
    while (start_side_ < 64 && 4 * start_side_ * start_side_ < nodes_.size()) start_side_ *= 2;
    starts_.assign(start_side_ * start_side_, last_);
    std::uint32_t from = last_;
    const std::int64_t step = 2 * kUnit / static_cast<std::int64_t>(start_side_);
    for (std::size_t row = 0; row < start_side_; ++row)
        for (std::size_t k = 0; k < start_side_; ++k) {
            // There and back again, so that each walk is short.
            const std::size_t column = row % 2 == 0 ? k : start_side_ - 1 - k;
            const Node middle = {static_cast<std::int64_t>(column) * step + step / 2 - kUnit,
                                 static_cast<std::int64_t>(row) * step + step / 2 - kUnit};
            from = walk(middle, from);
            starts_[row * start_side_ + column] = from;
        }
}

/// Twice the area of a, b, c: positive if they turn counter-clockwise.
std::int64_t Triangulation::orientation(std::uint32_t a, std::uint32_t b, const Node& c) const {
    const Node &p = nodes_[a], &q = nodes_[b];
    return (q.x - p.x) * (c.y - p.y) - (q.y - p.y) * (c.x - p.x);
}

bool Triangulation::in_circle(const Triangle& around, const Node& d) const {
    std::array<std::int64_t, 3> x{}, y{};
    std::array<Wide, 3> square{};
    for (std::size_t k = 0; k < 3; ++k) {
        x[k] = nodes_[around.node[k]].x - d.x;
        y[k] = nodes_[around.node[k]].y - d.y;
        square[k] = static_cast<Wide>(x[k] * x[k] + y[k] * y[k]);
    }
    const Wide determinant = square[0] * (x[1] * y[2] - x[2] * y[1]) +
                             square[1] * (x[2] * y[0] - x[0] * y[2]) +
                             square[2] * (x[0] * y[1] - x[1] * y[0]);
    return determinant > 0;
}

/// A triangle that holds the place, inside or on its border.
std::uint32_t Triangulation::walk(const Node& at, std::uint32_t from) const {
    std::uint32_t current = from, previous = kNone;
    while (true) {
        const Triangle& here = triangles_[current];
        std::uint32_t on = kNone;
        for (int k = 0; k < 3; ++k) {
            const std::uint32_t across = here.across[static_cast<std::size_t>(k)];
            if (across == previous || across == kNone) continue;
            if (orientation(here.node[static_cast<std::size_t>(next(k))],
                            here.node[static_cast<std::size_t>(before(k))], at) < 0) {
                on = across;
                break;
            }
        }
        if (on == kNone) return current;
        previous = current;
        current = on;
    }
}

void Triangulation::link(std::uint32_t triangle, std::uint32_t old_neighbour, std::uint32_t now) {
    if (triangle == kNone) return;
    for (std::uint32_t& across : triangles_[triangle].across)
        if (across == old_neighbour) {
            across = now;
            return;
        }
}

void Triangulation::split(std::uint32_t triangle, std::uint32_t node) {
    const Triangle whole = triangles_[triangle];
    const auto second = static_cast<std::uint32_t>(triangles_.size()), third = second + 1;
    triangles_[triangle] = {{node, whole.node[1], whole.node[2]}, {whole.across[0], second, third}};
    triangles_.push_back(
        {{node, whole.node[2], whole.node[0]}, {whole.across[1], third, triangle}});
    triangles_.push_back(
        {{node, whole.node[0], whole.node[1]}, {whole.across[2], triangle, second}});
    link(whole.across[1], triangle, second);
    link(whole.across[2], triangle, third);
    stack_ = {triangle, second, third};
}

/// `node` lies on the edge opposite to `corner`: both triangles at it become two.
void Triangulation::split_edge(std::uint32_t triangle, int corner, std::uint32_t node) {
    const Triangle one = triangles_[triangle];
    const auto at = [](int k) { return static_cast<std::size_t>(k); };
    const std::uint32_t other = one.across[at(corner)];
    const Triangle two = triangles_[other];
    int opposite = 0;
    while (two.across[at(opposite)] != triangle) ++opposite;
    const std::uint32_t a = one.node[at(corner)], b = one.node[at(next(corner))];
    const std::uint32_t c = one.node[at(before(corner))], d = two.node[at(opposite)];
    const std::uint32_t ab = one.across[at(before(corner))], ca = one.across[at(next(corner))];
    const std::uint32_t cd = two.across[at(before(opposite))], db = two.across[at(next(opposite))];
    const auto third = static_cast<std::uint32_t>(triangles_.size()), fourth = third + 1;
    triangles_[triangle] = {{node, a, b}, {ab, fourth, third}};
    triangles_[other] = {{node, d, c}, {cd, third, fourth}};
    triangles_.push_back({{node, c, a}, {ca, triangle, other}});
    triangles_.push_back({{node, b, d}, {db, other, triangle}});
    link(ca, triangle, third);
    link(db, other, fourth);
    stack_ = {triangle, other, third, fourth};
}

/// Flips edges opposite to `node`, which is every stacked triangle's first corner, until all
/// circles around it are empty.
void Triangulation::legalise(std::uint32_t node) {
    while (!stack_.empty()) {
        const std::uint32_t current = stack_.back();
        stack_.pop_back();
        const std::uint32_t other = triangles_[current].across[0];
        if (other == kNone || !in_circle(triangles_[other], nodes_[node])) continue;
        const Triangle one = triangles_[current], two = triangles_[other];
        int opposite = 0;
        while (two.across[static_cast<std::size_t>(opposite)] != current) ++opposite;
        const std::uint32_t d = two.node[static_cast<std::size_t>(opposite)];
        const std::uint32_t cd = two.across[static_cast<std::size_t>(before(opposite))];
        const std::uint32_t db = two.across[static_cast<std::size_t>(next(opposite))];
        // node, b, c and d, c, b become node, b, d and node, d, c.
        triangles_[current] = {{node, one.node[1], d}, {db, other, one.across[2]}};
        triangles_[other] = {{node, d, one.node[2]}, {cd, one.across[1], current}};
        link(db, other, current);
        link(one.across[1], current, other);
        stack_.push_back(current);
        stack_.push_back(other);
    }
}

void Triangulation::insert(std::uint32_t node) {
    const std::uint32_t found = walk(nodes_[node], last_);
    int on = -1;
    for (int k = 0; k < 3; ++k)
        if (orientation(triangles_[found].node[static_cast<std::size_t>(next(k))],
                        triangles_[found].node[static_cast<std::size_t>(before(k))],
                        nodes_[node]) == 0)
            on = k;
    if (on >= 0)
        split_edge(found, on, node);
    else
        split(found, node);
    last_ = found;
    legalise(node);
}

std::vector<std::uint32_t> Triangulation::inner() const {
    std::vector<std::uint32_t> list;
    for (std::size_t t = 0; t < triangles_.size(); ++t)
        if (std::none_of(triangles_[t].node.begin(), triangles_[t].node.end(),
                         [this](std::uint32_t n) { return helper(n); }))
            list.push_back(static_cast<std::uint32_t>(t));
    return list;
}

double Triangulation::area(std::uint32_t index) const {
    const Triangle& t = triangles_[index];
    const double unit = static_cast<double>(kUnit);
    return 0.5 * static_cast<double>(orientation(t.node[0], t.node[1], nodes_[t.node[2]])) /
           (unit * unit);
}

Triangulation::Place Triangulation::locate(Point at, std::uint32_t& hint) const {
    const Node place = rounded(at);
    const std::uint32_t found =
        walk(place, hint < triangles_.size() ? hint : starts_[start_cell(place)]);
    hint = found;
    const Triangle& t = triangles_[found];
    for (const std::uint32_t n : t.node)
        if (helper(n)) return {};
    const auto whole = static_cast<double>(orientation(t.node[0], t.node[1], nodes_[t.node[2]]));
    Place result{found, {}};
    for (int k = 0; k < 3; ++k)
        result.weight[static_cast<std::size_t>(k)] =
            static_cast<double>(orientation(t.node[static_cast<std::size_t>(next(k))],
                                            t.node[static_cast<std::size_t>(before(k))], place)) /
            whole;
    return result;
}

}  // namespace kiln::measured
