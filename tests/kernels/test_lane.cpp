// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "tests/kernels/one_lane.h"

TEST(Lane, ReciprocalRootIsGoodToEightInTenMillionOverAllNormalFloats) {
    double worst = 0;
    // Two octaves hold every mantissa and both parities of the exponent; a coarser walk covers the
    // rest.
    for (std::int32_t bits = 0x3F800000; bits < 0x40800000; bits += 7) {
        const float x = std::bit_cast<float>(bits);
        worst =
            std::max(worst, std::abs(double(in_float::lane_rsqrt(x)) * std::sqrt(double(x)) - 1));
    }
    for (std::int32_t bits = 0x00800000; bits < 0x7F000000; bits += 100003) {
        const float x = std::bit_cast<float>(bits);
        worst =
            std::max(worst, std::abs(double(in_float::lane_rsqrt(x)) * std::sqrt(double(x)) - 1));
    }
    // 3/2 · (6.5e-4)² of the last step, and roundings of 6e-8 in its three products.
    EXPECT_LE(worst, 8e-7);
    EXPECT_GT(worst, 1e-8);  // otherwise it was not float arithmetic that was tried
}
