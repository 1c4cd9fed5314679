// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/reference/reference.h"

// Closed forms, limits and the white furnace. 1e-12 is the stated accuracy of the library.
namespace kiln::reference {
namespace {

constexpr double kExact = 1e-12;
constexpr double kLn2 = std::numbers::ln2;
constexpr Masking kBoth[] = {Masking::correlated, Masking::separable};

TEST(ReferenceLimits, RoughestLobeHasItsClosedForms) {
    for (const double mu : {1e-6, 1e-3, .02, .1, .3, .5, .77, .999, 1.}) {
        const double correlated = 1 - mu * std::log1p(1 / mu),
                     separable = 2 * (1 - kLn2) / (1 + mu);
        EXPECT_NEAR(directional_albedo(mu, 1, Masking::correlated), correlated, kExact) << mu;
        EXPECT_NEAR(directional_albedo(mu, 1, Masking::separable), separable, kExact) << mu;
        EXPECT_NEAR(deficit(mu, 1, Masking::correlated) / (1 - correlated), 1, 1e-9) << mu;
        EXPECT_NEAR(deficit(mu, 1, Masking::separable) / (1 - separable), 1, 1e-9) << mu;
    }
    EXPECT_NEAR(average_albedo(1, Masking::correlated), 4. / 3 * (1 - kLn2), kExact);
    EXPECT_NEAR(average_albedo(1, Masking::separable), 4 * (1 - kLn2) * (1 - kLn2), kExact);
}

TEST(ReferenceLimits, MirrorReflectsAll) {
    for (const Masking masking : kBoth) {
        for (const double mu : {0., .1, .5, 1.}) {
            const double grazing = std::pow(1 - mu, 5);
            EXPECT_EQ(directional_albedo(mu, 0, masking), 1);
            EXPECT_EQ(deficit(mu, 0, masking), 0);
            EXPECT_EQ(split_sum(mu, 0, masking).bias, grazing);
            EXPECT_EQ(split_sum(mu, 0, masking).scale, 1 - grazing);
            EXPECT_EQ(albedo_with_fresnel(mu, 0, masking, [](double u) { return u * u; }), mu * mu);
        }
        EXPECT_EQ(average_albedo(0, masking), 1);
        EXPECT_EQ(average_deficit(0, masking), 0);
    }
}

// At NoV = 0 nothing is masked by the height-correlated form: E = 1 for every alpha > 0, which the
// integral must find by itself.
TEST(ReferenceLimits, GrazingViewKeepsAllWhenCorrelated) {
    for (const double alpha : {1e-4, 1e-3, .01, .1, .25, .5, 1.}) {
        EXPECT_NEAR(directional_albedo(0, alpha, Masking::correlated), 1, kExact) << alpha;
        EXPECT_EQ(deficit(0, alpha, Masking::correlated), 0) << alpha;
    }
    // Values outside this library, six digits.
    EXPECT_NEAR(directional_albedo(0, 1e-6, Masking::separable), .936135, 5.1e-7);
    EXPECT_NEAR(directional_albedo(0, .01, Masking::separable), .936061, 5.1e-7);
    EXPECT_NEAR(directional_albedo(0, .1, Masking::separable), .929295, 5.1e-7);
    EXPECT_NEAR(directional_albedo(0, .25, Masking::separable), .898580, 5.1e-7);
    EXPECT_NEAR(directional_albedo(0, 1, Masking::separable), 2 * (1 - kLn2), kExact);
    EXPECT_NEAR(deficit(0, 1, Masking::separable), 1 - 2 * (1 - kLn2), kExact);
}

TEST(ReferenceLimits, MaskingsCoincideAtNormalView) {
    for (const double alpha : {1e-4, .01, .3, 1.}) {
        EXPECT_NEAR(directional_albedo(1, alpha, Masking::correlated),
                    directional_albedo(1, alpha, Masking::separable), kExact);
        EXPECT_NEAR(split_sum(1, alpha, Masking::correlated).bias,
                    split_sum(1, alpha, Masking::separable).bias, kExact);
    }
}

// mu = s alpha, alpha -> 0: the albedo tends to g(s). The next term is of order alpha^2 (8.8e-5 at
// s = 1, alpha = .01), 1e-10 here, below the six digits given.
TEST(ReferenceLimits, AlbedoDipsWhereTheViewIsAsSteepAsTheLobe) {
    const struct {
        double s, correlated, separable;
    } dip[] = {{.1, .979642, .926859},
               {.3, .944659, .908688},
               {1, .892075, .881618},
               {3, .944648, .943860},
               {10, .994183, .994175}};
    for (const auto& g : dip) {
        EXPECT_NEAR(directional_albedo(g.s * 1e-5, 1e-5, Masking::correlated), g.correlated,
                    5.1e-7);
        EXPECT_NEAR(directional_albedo(g.s * 1e-5, 1e-5, Masking::separable), g.separable, 5.1e-7);
    }
    const struct { double alpha, mu, lowest; } minimum[] = {{.1, .112, .8827}, {.25, .30, .8379}};
    for (const auto& m : minimum) {
        const double value = directional_albedo(m.mu, m.alpha, Masking::correlated);
        EXPECT_NEAR(value, m.lowest, 5.1e-5);
        EXPECT_GT(directional_albedo(m.mu * .8, m.alpha, Masking::correlated), value);
        EXPECT_GT(directional_albedo(m.mu * 1.2, m.alpha, Masking::correlated), value);
    }
}

// alpha -> 0 at fixed mu: 1 - E -> alpha^2 (1 + mu^-2) / 2. The lobe's tail falls like tan^-4, so
// the next term is smaller by alpha / mu only: 16 % at alpha = .01, mu = .1 bounds it by 1.6 alpha
// / mu.
TEST(ReferenceLimits, DeficitOfASmoothLobe) {
    for (const Masking masking : kBoth)
        for (const double mu : {.3, .5, .8, 1.})
            for (const double alpha : {1e-4, 1e-3}) {
                const double leading = alpha * alpha * (1 + 1 / (mu * mu)) / 2;
                EXPECT_NEAR(deficit(mu, alpha, masking) / leading, 1, 1.6 * alpha / mu)
                    << mu << ' ' << alpha;
            }
    EXPECT_NEAR(deficit(.1, .01, Masking::correlated) / (1e-4 * 101 / 2), 1.16, .005);
}

// 1 - E_avg -> alpha^2 (ln(1 / alpha) + c): within 1e-5 at alpha 1e-3 and, next term of order
// alpha^2 ln, below the six digits of c (5e-7 / 9.7) at 1e-4.
TEST(ReferenceLimits, AverageDeficitOfASmoothLobe) {
    const struct {
        Masking masking;
        double constant;
    } forms[] = {{Masking::correlated, .489235}, {Masking::separable, .540052}};
    for (const auto& form : forms) {
        const auto ratio = [&](double alpha) {
            return average_deficit(alpha, form.masking) /
                   (alpha * alpha * (std::log(1 / alpha) + form.constant));
        };
        EXPECT_NEAR(ratio(1e-3), 1, 1e-5);
        EXPECT_NEAR(ratio(1e-4), 1, 2e-7);
    }
}

// Integral of mu deficit(mu) by another rule than the library's: composite Gauss-Legendre with 5
// points on panels that double from alpha / 1024 to 1, each halved. Its error is that of a
// tenth-degree remainder on panels of half an octave: below 1e-9 relative.
double average_by_panels(double alpha, Masking masking) {
    const double outer = std::sqrt(5 + 2 * std::sqrt(10. / 7)) / 3;
    const double inner = std::sqrt(5 - 2 * std::sqrt(10. / 7)) / 3;
    const double node[] = {-outer, -inner, 0, inner, outer};
    const double w_outer = (322 - 13 * std::sqrt(70.)) / 900,
                 w_inner = (322 + 13 * std::sqrt(70.)) / 900;
    const double weight[] = {w_outer, w_inner, 128. / 225, w_inner, w_outer};
    double sum = 0;
    double begin = 0, end = alpha / 1024;
    while (begin < 1) {
        for (int i = 0; i < 5; ++i) {
            const double mu = (begin + end) / 2 + (end - begin) / 2 * node[i];
            sum += (end - begin) / 2 * weight[i] * mu * deficit(mu, alpha, masking);
        }
        begin = end;
        end = std::min(1., end * (end < .1 ? std::numbers::sqrt2 : 1.15));
    }
    return 2 * sum;
}

// f_ms = (1 - E(o)) (1 - E(i)) / (pi (1 - E_avg)) gives back what the single-scattering lobe loses.
// Two relative errors of 1e-8 and 1e-9, times a deficit below 1.
TEST(ReferenceLimits, WhiteFurnaceIsClosedByTheMultipleScatteringLobe) {
    for (const Masking masking : kBoth)
        for (const double alpha : {.03, .4}) {
            const double share =
                average_by_panels(alpha, masking) / average_deficit(alpha, masking);
            EXPECT_NEAR(share, 1, 2e-8) << alpha;
            for (const double mu : {.01, .2, 1.})
                EXPECT_NEAR(
                    directional_albedo(mu, alpha, masking) + deficit(mu, alpha, masking) * share, 1,
                    2e-8);
        }
}

}  // namespace
}  // namespace kiln::reference
