// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>
#include <vector>

#include "server/compute/points.h"
#include "tests/kernels/one_lane.h"

// The parts of a walk; what walks come to is held in tests/compute/test_models_simulated.cpp.
namespace {

using kiln::PointKind;

TEST(WalkRow, IsAPermutationOfTheBatchForEveryTurn) {
    for (const unsigned count : {1U, 2U, 3U, 37U, 64U, 1000U, 1024U})
        for (unsigned turn = 0; turn < 5; ++turn) {
            std::set<unsigned> rows;
            for (unsigned i = 0; i < count; ++i)
                rows.insert(in_double::walk_row(turn, i, 2048, count));
            EXPECT_EQ(rows.size(), count) << turn;
            EXPECT_EQ(*rows.rbegin(), count - 1) << turn;
        }
}

// Two random permutations of 1024 agree at one place on average (Poisson): ten or more are one in
// ten million. Steps from row to row repeat as seldom.
TEST(WalkRow, TurnsAndBatchesAreUnlike) {
    const auto alike = [](unsigned turn, unsigned batch, unsigned other_turn, unsigned other) {
        int count = 0;
        for (unsigned i = 0; i < 1024; ++i)
            count += in_double::walk_row(turn, i, batch, 1024) ==
                             in_double::walk_row(other_turn, i, other, 1024)
                         ? 1
                         : 0;
        return count;
    };
    for (unsigned turn = 1; turn < 5; ++turn) {
        for (unsigned other = 0; other < turn; ++other) EXPECT_LT(alike(turn, 0, other, 0), 10);
        for (const unsigned batch : {1024U, 2048U, 65536U})
            EXPECT_LT(alike(turn, 0, turn, batch), 10) << turn << ' ' << batch;
    }
}

/// Mean cosine to the surface of the visible normals of w = (sine, 0, cosine), by a midpoint rule
/// over tan(theta) = alpha t / (1 - t) and the azimuth.
double mean_upright(double alpha, double cosine) {
    constexpr int kSteps = 1500;
    const double sine = std::sqrt(1 - cosine * cosine);
    double seen = 0, upright = 0;
    for (int i = 0; i < kSteps; ++i) {
        const double t = (i + .5) / kSteps, slope = alpha * t / (1 - t);
        const double c = 1 / std::sqrt(1 + slope * slope), s = slope * c;
        // D sin dtheta = (tan / (1 + tan^2 / alpha^2)^2) / (pi alpha^2 cos^2) dtan
        const double spread = 1 + slope * slope / (alpha * alpha);
        const double weight = slope / (c * spread * spread) / ((1 - t) * (1 - t));
        for (int j = 0; j < kSteps; ++j) {
            const double phi = std::numbers::pi * (j + .5) / kSteps;
            const double facing = std::max(0.0, cosine * c + sine * s * std::cos(phi));
            seen += weight * facing;
            upright += weight * facing * c;
        }
    }
    return upright / seen;
}

// Normals by weight, of light that comes down and up: both laws at the points of their mixture.
TEST(WalkFacet, WeighsTheNormalsThatEitherRaySees) {
    constexpr std::size_t kCount = 1 << 16;
    const kiln::PointSet points =
        kiln::make_points(kiln::Sampler::sobol_owen, PointKind::facet_walk, 3, kCount);
    constexpr struct { double down, up; } kPairs[] = {{1, .01}, {.95, .2}, {.3, .8}, {.01, .4}};
    for (const double alpha : {.05, .4, 1.})
        for (const auto [NoV, rise] : kPairs) {
            const auto down = in_double::ggx_view(NoV, alpha),
                       up = in_double::ggx_view(rise, alpha);
            const double of_down = mean_upright(alpha, NoV), of_up = mean_upright(alpha, -rise);
            for (const double part_up : {0., .3, 1.}) {
                double seen_down = 0, seen_up = 0, upright_down = 0, upright_up = 0;
                for (std::size_t i = 0; i < kCount; ++i) {
                    const auto facet = in_double::walk_facet(down, up, part_up,
                                                             points.values[kiln::kWalkScalars * i]);
                    seen_down += facet.of_down / kCount;
                    seen_up += facet.of_up / kCount;
                    upright_down += facet.of_down * facet.upright / kCount;
                    upright_up += facet.of_up * facet.upright / kCount;
                }
                // 16 stratified sets of 4096 points and the midpoint rule: less than 1e-5 was seen,
                // and 7e-5 where light comes up, whose weight reaches 9 at the cosine .8.
                EXPECT_NEAR(seen_down, 1, 1e-5) << alpha << ' ' << NoV << ' ' << part_up;
                EXPECT_NEAR(upright_down, of_down, 1e-5) << alpha << ' ' << NoV << ' ' << part_up;
                if (part_up == 0) continue;  // none comes up, nor is drawn for
                EXPECT_NEAR(seen_up, 1, 1e-4) << alpha << ' ' << rise << ' ' << part_up;
                EXPECT_NEAR(upright_up, of_up, 1e-4) << alpha << ' ' << rise << ' ' << part_up;
            }
        }
}

// A cosine lobe about m has the mean 2/3 m and the mean square 1/4 + m.z^2 / 4 of cosines, of which
// (1 + m.z) / 2 go up.
TEST(WalkFacet, SendsACosineLobeUpAndDown) {
    constexpr std::size_t kCount = 1 << 16;
    const kiln::PointSet points =
        kiln::make_points(kiln::Sampler::sobol_owen, PointKind::facet_walk, 3, kCount);
    for (const double h : {1., .99, .7, .2, 1e-3, 0.}) {
        const double slant = std::sqrt((1 - h) * (1 + h));
        const double up = (1 + h) / 2, down = (1 - h) / 2;
        double mean = 0, square = 0;
        for (std::size_t i = 0; i < kCount; ++i) {
            const double* point = &points.values[kiln::kWalkScalars * i];
            const double rise = in_double::walk_light(h, slant, point[1], point[2]);
            const double fall = in_double::walk_light(-h, slant, point[2], point[1]);
            ASSERT_GE(rise, 0);
            ASSERT_LE(rise, 1);
            ASSERT_GE(fall, 0);
            ASSERT_LE(fall, 1);
            mean += up * rise - down * fall;
            square += up * rise * rise + down * fall * fall;
        }
        EXPECT_NEAR(mean / kCount, 2. / 3 * h, 2e-6) << h;
        EXPECT_NEAR(square / kCount, (1 + h * h) / 4, 2e-6) << h;
    }
}

/// Of light from facets of every inclination, the least and the most of its cosines. `walk_light`:
/// of h, slant, near and far, in one precision.
template <typename Scalar, typename WalkLight>
std::array<Scalar, 2> ends_of_light(WalkLight walk_light) {
    const Scalar step = std::numeric_limits<Scalar>::epsilon();
    std::array<Scalar, 2> ends{1, 0};
    for (const Scalar upright : {Scalar(1), 1 - step, Scalar(.7), Scalar(1e-3), step, Scalar(0)})
        for (const Scalar h : {upright, -upright}) {
            const Scalar slant = std::sqrt((1 - h) * (1 + h));
            for (int i = 0; i <= 64; ++i)
                for (int j = 0; j <= 64; ++j) {
                    const double v = i / 64., psi = std::numbers::pi * j / 64;
                    const double sine = std::sin(psi), along = std::sqrt(v) * std::cos(psi);
                    const double root = std::sqrt(std::max(0.0, 1 - v * sine * sine));
                    const Scalar cosine =
                        walk_light(h, slant, static_cast<Scalar>((root - along) / 2),
                                   static_cast<Scalar>((root + along) / 2));
                    ends = {std::min(ends[0], cosine), std::max(ends[1], cosine)};
                }
        }
    return ends;
}

// A walk divides by it and by its square: light along the surface, or a rounding below, is above.
TEST(WalkLight, IsAboveTheSurfaceToTheLastBit) {
    const auto [least_float, most_float] =
        ends_of_light<float>([](auto h, auto slant, auto near, auto far) {
            return in_float::walk_light(h, slant, near, far);
        });
    EXPECT_GE(least_float, std::sqrt(std::numeric_limits<float>::min()));
    EXPECT_LE(most_float, 1);
    const auto [least, most] = ends_of_light<double>([](auto h, auto slant, auto near, auto far) {
        return in_double::walk_light(h, slant, near, far);
    });
    EXPECT_GE(least, std::sqrt(std::numeric_limits<double>::min()));
    EXPECT_LE(most, 1);
}

// White facets lose nothing, however a walk goes: 15 facets and the end sum to 1.
TEST(Walk, WhiteLosesNothing) {
    const kiln::PointSet points =
        kiln::make_points(kiln::Sampler::random, PointKind::facet_walk, 5, 1024);
    const std::vector<float> narrow(points.values.begin(), points.values.end());
    const double white[] = {1, 0, .5};
    const float white_float[] = {1, 0, .5};
    for (const double alpha : {0., 1e-4, .3, 1.})
        for (const double NoV : {0., 1e-3, .5, 1.})
            for (unsigned i = 0; i < 64; ++i) {
                const auto walked = in_double::ggx_lambert_walk(
                    7, white, in_double::ggx_view(NoV, alpha), points.values.data(), i, 0, 64);
                EXPECT_NEAR(walked.albedo[0], 1, 1e-14) << alpha << ' ' << NoV;
                EXPECT_EQ(walked.albedo[1], 0);
                // What weights add is taken back at an average: a walk alone may pass its albedo.
                EXPECT_GT(walked.albedo[2], 0);
                EXPECT_LE(walked.albedo[2], .53);
                const auto rounded = in_float::ggx_lambert_walk(
                    1, white_float,
                    in_float::ggx_view(static_cast<float>(NoV), static_cast<float>(alpha)),
                    narrow.data(), i, 0, 64);
                // Fifteen subtractions of parts of 1, each rounded to 6e-8.
                EXPECT_NEAR(rounded.albedo[0], 1, 4e-6F) << alpha << ' ' << NoV;
            }
}

}  // namespace
