// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "tests/kernels/one_lane.h"

TEST(Schlick, WeighsTheFifthPower) {
    for (const double VoH : {0.0, 0.1, 0.5, 0.9, 1.0})
        // Four multiplications of relative rounding 1.1e-16.
        EXPECT_NEAR(in_double::fresnel_schlick_weight(VoH), std::pow(1 - VoH, 5), 5e-16) << VoH;
}

TEST(Schlick, ACosineThatRoundingPutAboveOneWeighsNothing) {
    EXPECT_EQ(in_float::fresnel_schlick_weight(1.0000001f), 0.0f);
    EXPECT_EQ(in_double::fresnel_schlick_weight(1.0 + 1e-9), 0.0);
}
