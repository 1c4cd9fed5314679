// SPDX-License-Identifier: Apache-2.0
// What the measured kernels are made of, against the C library and the paper's curve.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/kernels/one_lane.h"

namespace {

constexpr double kPi = std::numbers::pi;

TEST(LaneTable, TurnsAreTheArcTangent) {
    for (int n = 0; n < 4096; ++n) {
        const double turn = (n + 0.25) / 4096, size = 1e-3 + n % 7;
        const double x = size * std::cos(2 * kPi * turn), y = size * std::sin(2 * kPi * turn);
        EXPECT_NEAR(in_double::lane_turn(x, y), turn, 2e-16);
        // A float's coordinates alone move the azimuth by 1e-8 of a turn.
        EXPECT_NEAR(in_float::lane_turn(static_cast<float>(x), static_cast<float>(y)), turn, 1e-7f);
    }
    EXPECT_EQ(in_float::lane_turn(0, 0), 0);
    EXPECT_EQ(in_float::lane_turn(-1, 0), 0.5f);
    EXPECT_EQ(in_float::lane_turn(0, -2), 0.75f);
}

TEST(LaneTable, FloorsAndLinesAreExact) {
    for (const float x : {0.0f, 0.25f, 0.99999994f, 1.0f, 7.5f, 8.5f, 255.99998f, 4194303.5f})
        EXPECT_EQ(in_float::lane_floor(x), std::floor(x)) << x;
    const float table[] = {9, 1, 3, 7};
    EXPECT_EQ(in_float::lane_between(table, 1, 0.5f, 2), 2);
    EXPECT_EQ(in_float::lane_between(table, 1, 2, 2), 7);
}

/// The Bezier curve by its own parameter, from 0 at the edge (nothing lost) to p at the horizon.
TEST(Measured, TheTailIsTheCurveOfThePaper) {
    for (const double l : {0.0, 0.3, 0.5, 0.7, 1.0})
        for (double t = 0; t <= 1; t += 0.0625) {
            const double x = 2 * (1 - t) * t * l + t * t, y = 2 * (1 - t) * t * (1 - l) + t * t;
            EXPECT_NEAR(in_double::measured_tail(0.2, l, x), 1 - y + 0.2 * y, 1e-7) << l << t;
            EXPECT_EQ(in_double::measured_tail(1, l, x), 1);
        }
}

TEST(Measured, SwappedTwiceIsTheSame) {
    const double theta = 0.7, tilt = 1.1, turn = 2.3;
    const in_double::MeasuredPair at = {theta,
                                        std::cos(theta),
                                        std::sin(theta),
                                        std::sin(tilt) * std::cos(turn),
                                        std::sin(tilt) * std::sin(turn),
                                        std::cos(tilt)};
    const auto back = in_double::measured_swapped(at);
    EXPECT_NEAR(back.theta, tilt, 1e-15);
    EXPECT_NEAR(std::atan2(back.y, back.x), -turn, 1e-15);
    const auto again = in_double::measured_swapped(back);
    EXPECT_NEAR(again.theta, theta, 1e-15);
    EXPECT_NEAR(again.x, at.x, 1e-15);
    EXPECT_NEAR(again.y, at.y, 1e-15);
    EXPECT_NEAR(again.z, at.z, 1e-15);
}

}  // namespace
