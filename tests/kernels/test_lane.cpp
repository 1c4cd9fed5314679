// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "tests/kernels/one_lane.h"

namespace {

/// The greatest relative error of `function` against `exact` over normal floats: two octaves hold
/// every mantissa and both parities of the exponent, a coarser walk covers the rest.
template <typename Function, typename Exact>
double worst_over_normal_floats(Function function, Exact exact) {
    double worst = 0;
    const auto visit = [&](std::int32_t bits) {
        const float x = std::bit_cast<float>(bits);
        worst = std::max(worst, std::abs(double(function(x)) / exact(double(x)) - 1));
    };
    for (std::int32_t bits = 0x3F800000; bits < 0x40800000; bits += 7) visit(bits);
    for (std::int32_t bits = 0x00800000; bits < 0x7F000000; bits += 100003) visit(bits);
    return worst;
}

}  // namespace

// The polynomials' own greatest errors are 5.4e-7 and 1.6e-8; about two roundings of 6e-8 come on
// top.
TEST(Lane, ReciprocalRootIsGoodToSevenInTenMillionOverAllNormalFloats) {
    const double worst = worst_over_normal_floats([](float x) { return in_float::lane_rsqrt(x); },
                                                  [](double x) { return 1 / std::sqrt(x); });
    EXPECT_LE(worst, 7e-7);
    EXPECT_GT(worst, 1e-8);  // otherwise it was not float arithmetic that was tried
}

// A power of two in front rounds nothing more.
TEST(Lane, SumWithAReciprocalRootIsAsGood) {
    const double worst =
        worst_over_normal_floats([](float x) { return in_float::lane_fma_rsqrt(-4.0f, x, 0.0f); },
                                 [](double x) { return -4 / std::sqrt(x); });
    EXPECT_LE(worst, 7e-7);
    EXPECT_GT(worst, 1e-8);
    EXPECT_EQ(in_double::lane_fma_rsqrt(-3, 4, 5), 3.5);
}

TEST(Lane, RootIsGoodToTwoRoundingsOverAllNormalFloats) {
    const double worst = worst_over_normal_floats([](float x) { return in_float::lane_root(x); },
                                                  [](double x) { return std::sqrt(x); });
    EXPECT_LE(worst, 1.9e-7);
    EXPECT_GT(worst, 6e-8);
    EXPECT_EQ(in_float::lane_root(0.0f), 0.0f);
}
