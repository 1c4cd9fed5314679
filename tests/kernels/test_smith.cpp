// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <random>

#include "tests/kernels/one_lane.h"

namespace {

/// Heitz 2014, eq. 72, as printed.
double lambda(double cosine, double alpha) {
    const double tangent2 = (1 - cosine * cosine) / (cosine * cosine);
    return (std::sqrt(1 + alpha * alpha * tangent2) - 1) / 2;
}

double textbook_G2_over_G1(int masking, double NoV, double NoL, double alpha) {
    const double G1_view = 1 / (1 + lambda(NoV, alpha));
    if (masking == KILN_MASKING_SMITH_SEPARABLE) return 1 / (1 + lambda(NoL, alpha));
    return 1 / (1 + lambda(NoV, alpha) + lambda(NoL, alpha)) / G1_view;
}

double smith_length(double NoX, double alpha) {
    return std::sqrt(NoX * NoX + alpha * alpha * (1 - NoX * NoX));
}

struct Directions {
    double NoV, NoL, alpha, scale;
};

Directions draw(std::mt19937_64& random) {
    std::uniform_real_distribution<double> cosine(0.02, 1), width(0.05, 1), scale(0.1, 5);
    return {cosine(random), cosine(random), width(random), scale(random)};
}

}  // namespace

TEST(Smith, RatiosAreHeitzsInAnyScaleOfTheLight) {
    std::mt19937_64 random(1);
    for (int i = 0; i < 100000; ++i) {
        const auto [NoV, NoL, alpha, scale] = draw(random);
        const double c = NoV / smith_length(NoV, alpha), S = scale * smith_length(NoL, alpha);
        for (const int masking : {KILN_MASKING_SMITH_CORRELATED, KILN_MASKING_SMITH_SEPARABLE}) {
            const double wanted = textbook_G2_over_G1(masking, NoV, NoL, alpha);
            // Lambda's √(1 + x) − 1 loses up to 1 / x = 2 / (α tanθ)² of 1e-16 where it matters
            // least: 1e-12 in all.
            EXPECT_NEAR(in_double::smith_G2_over_G1(masking, c, scale * NoL, S), wanted, 1e-12);
            const double excess = scale * scale * alpha * alpha * (1 - NoL * NoL);
            EXPECT_NEAR(in_double::smith_deficit(masking, c, scale * NoL, S, excess), 1 - wanted,
                        1e-12);
        }
    }
}

TEST(Smith, TheDeficitKeepsItsDigitsInFloat) {
    std::mt19937_64 random(2);
    std::uniform_real_distribution<double> cosine(0.05, 0.999), exponent(-4, -1);
    for (int i = 0; i < 100000; ++i) {
        const auto NoV = static_cast<float>(cosine(random)),
                   NoL = static_cast<float>(cosine(random));
        const auto alpha = static_cast<float>(std::pow(10, exponent(random)));
        for (const int masking : {KILN_MASKING_SMITH_CORRELATED, KILN_MASKING_SMITH_SEPARABLE}) {
            const auto in = [&]<typename T>(T) {
                const T v = NoV, l = NoL, a = alpha, one = 1;
                const T excess = a * a * ((one - l) * (one + l));
                const T S = std::sqrt(l * l + excess);
                const T S_view = std::sqrt(v * v + a * a * ((one - v) * (one + v)));
                if constexpr (std::is_same_v<T, float>)
                    return in_float::smith_deficit(masking, v / S_view, l, S, excess);
                else
                    return in_double::smith_deficit(masking, v / S_view, l, S, excess);
            };
            const double exact = in(0.0);
            // Some twenty roundings of 6e-8 each, of which the square doubles a few; 1 − G2/G1 by
            // subtraction is wrong in its first digit here.
            EXPECT_NEAR(in(0.0f) / exact, 1, 1.5e-6) << NoV << " " << NoL << " " << alpha;
        }
    }
}

TEST(Smith, CorrelatedMaskingAtGrazingViewTakesNothing) {
    // Heitz 2014: Λ(V) → ∞ dominates both G1 and G2.
    EXPECT_DOUBLE_EQ(in_double::smith_G2_over_G1(KILN_MASKING_SMITH_CORRELATED, 0.0, 0.3, 0.5),
                     1.0);
    EXPECT_DOUBLE_EQ(in_double::smith_deficit(KILN_MASKING_SMITH_CORRELATED, 0.0, 0.3, 0.5, 0.16),
                     0.0);
}
