// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <numeric>
#include <stdexcept>
#include <vector>

#include "tests/reference/ggx_lambert.h"
#include "tests/reference/tanh_sinh.h"

// Lambertian GGX microfacets: quadrature and walks share no step, so they must meet.
namespace kiln::reference {
namespace {

constexpr double kPi = std::numbers::pi;
// Five standard errors: once in 1.7 million; the seeds are fixed, so a pass stays one.
constexpr double kSigmas = 5;

TEST(GgxLambert, FirstBounceOfTheWalkIsTheQuadrature) {
    std::uint64_t seed = 1;
    for (const double alpha : {.02, .25, 1.})
        for (const double mu : {.02, .3, 1.}) {
            const WalkedAlbedo walked =
                ggx_lambert_walked_albedo(alpha, mu, 1, alpha < 1 ? 50000 : 300000, seed++);
            EXPECT_NEAR(walked.single.mean, ggx_lambert_single_albedo(alpha, mu),
                        kSigmas * walked.single.standard_error)
                << alpha << ' ' << mu;
            EXPECT_LT(walked.single.standard_error, alpha < 1 ? 2e-3 : 1e-3);
        }
    const WalkedAlbedo average = ggx_lambert_walked_average(.5, 1, 100000, 5);
    EXPECT_NEAR(average.single.mean, ggx_lambert_single_average(.5),
                kSigmas * average.single.standard_error);
}

// Every walk leaves the surface: nothing is lost at rho = 1, and at rho < 1 the albedo lies between
// the first bounce alone and rho.
TEST(GgxLambert, WhiteMicrofacetsReflectAll) {
    for (const double alpha : {.1, 1.}) {
        const WalkedAlbedo white = ggx_lambert_walked_albedo(alpha, .2, 1, 20000, 11);
        EXPECT_EQ(white.all.mean, 1);
        EXPECT_EQ(white.all.standard_error, 0);
        const WalkedAlbedo grey = ggx_lambert_walked_albedo(alpha, .2, .5, 20000, 11);
        EXPECT_GT(grey.all.mean, grey.single.mean + 10 * grey.all.standard_error);
        EXPECT_LT(grey.all.mean, .5 - 10 * grey.all.standard_error);
    }
    EXPECT_EQ(ggx_lambert_walked_average(.7, 1, 1000, 2).all.mean, 1);
}

TEST(GgxLambert, SmoothIsLambert) {
    for (const double mu : {.2, .7, 1.}) {
        EXPECT_NEAR(ggx_lambert_single_albedo(1e-3, mu), 1, 1e-3) << mu;
        EXPECT_NEAR(ggx_lambert_single(1e-3, mu, .5, .2), 1 / kPi, 1e-3) << mu;
    }
    EXPECT_LT(ggx_lambert_single_albedo(.5, .5), .8);
}

// alpha = 1 makes D = 1 / pi, and around NoV = 1 the integral of <n,m> <L,m> over m is
// (2/3) (sin + (pi - angle) cos) of the angle to L. One integral over NoL remains.
TEST(GgxLambert, RoughestSurfaceSeenFromAbove) {
    const TanhSinh& rule = tanh_sinh(6);
    double sum = 0;
    for (std::size_t j = 0; j < rule.weight.size(); ++j) {
        const double l = rule.from0[j], angle = std::acos(l);
        sum += rule.weight[j] * 2 * l / (1 + l) * 2 / 3 * (std::sin(angle) + (kPi - angle) * l);
    }
    EXPECT_NEAR(ggx_lambert_single_albedo(1, 1), 2 / kPi * sum, 1e-9);
    EXPECT_NEAR(ggx_lambert_single_albedo(1, 1, Masking::separable), 2 / kPi * sum, 1e-9);
}

// The point function integrated by a midpoint rule over NoL^2 and the azimuth; n points each leave
// 1/n^2 = 2e-2 times the relative spread of a function that is nearly constant, some 0.2.
TEST(GgxLambert, PointFunctionSumsToTheAlbedo) {
    constexpr int n = 7;
    double sum = 0;
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j)
            sum +=
                ggx_lambert_single(.5, .6, std::sqrt((i + .5) / n), std::cos(kPi * (j + .5) / n));
    EXPECT_NEAR(kPi * sum / (n * n), ggx_lambert_single_albedo(.5, .6), 4e-3);
    // Masking is a factor that knows no azimuth: G1 G1 (1 + Lv + Ll).
    const auto lambda = [](double c) { return (std::sqrt(1 + .25 * (1 / (c * c) - 1)) - 1) / 2; };
    const double v = lambda(.6), l = lambda(.2);
    EXPECT_NEAR(ggx_lambert_single(.5, .6, .2, .1, Masking::separable) /
                    ggx_lambert_single(.5, .6, .2, .1, Masking::correlated),
                (1 + v + l) / ((1 + v) * (1 + l)), 1e-6);
    EXPECT_NEAR(ggx_lambert_single(.4, .3, .9, -.5), ggx_lambert_single(.4, .9, .3, -.5), 1e-6);
}

// Helmholtz: among cosine-distributed views, as many paths lead from band to band (of cosines
// above and below 1/2) as back, whatever their number of bounces.
TEST(GgxLambert, WalksAreReciprocal) {
    std::mt19937_64 random(3);
    constexpr int n = 200000;
    int down = 0, up = 0;
    for (int i = 0; i < n; ++i) {
        const double view = std::sqrt((i + .5) / n);
        const Walk walk = ggx_lambert_walk(.8, view, random);
        if (walk.bounces < 2) continue;
        down += view > .5 && walk.NoL <= .5 ? 1 : 0;
        up += view <= .5 && walk.NoL > .5 ? 1 : 0;
    }
    EXPECT_GT(down, 1000);
    EXPECT_NEAR(down, up, kSigmas * std::sqrt(down + up));
}

double sum(const std::vector<double>& values) {
    return std::accumulate(values.begin(), values.end(), 0.0);
}

// Three ways to the same numbers: invariance, quadrature of the first bounce, and walks.
TEST(GgxLambert, InvarianceIsTheQuadratureAndTheWalk) {
    const std::vector<double> views = {.1, .3, 1};
    for (const double alpha : {.1, .25, .6}) {
        const auto shares = ggx_lambert_shares(alpha, views, 40);
        for (std::size_t v = 0; v < views.size(); ++v) {
            EXPECT_NEAR(shares[v][0], ggx_lambert_single_albedo(alpha, views[v]), 1e-8);
            // Nothing is lost; .54 of what is inside goes on at each bounce at alpha = .6.
            EXPECT_NEAR(sum(shares[v]), 1, 1e-8) << alpha << ' ' << views[v];
            const WalkedAlbedo walked = ggx_lambert_walked_albedo(alpha, views[v], .6, 20000, 77);
            EXPECT_NEAR(ggx_lambert_albedo(shares[v], .6), walked.all.mean,
                        kSigmas * walked.all.standard_error)
                << alpha << ' ' << views[v];
        }
        EXPECT_NEAR(sum(ggx_lambert_average_shares(alpha, 40)), 1, 1e-8);
    }
    EXPECT_NEAR(ggx_lambert_average_shares(.25, 1)[0], ggx_lambert_single_average(.25), 1e-7);
    const WalkedAlbedo average = ggx_lambert_walked_average(.6, .6, 50000, 8);
    EXPECT_NEAR(ggx_lambert_albedo(ggx_lambert_average_shares(.6, 40), .6), average.all.mean,
                kSigmas * average.all.standard_error);
}

// Bounds of the reference itself: fewer ordinates move it by less than what it promises.
TEST(GgxLambert, OrdinatesHaveConverged) {
    const std::vector<double> views = {.1, .5, 1};
    for (const double alpha : {.1, .5, 1.}) {
        const auto coarse = ggx_lambert_shares(alpha, views, 10, 28);
        const auto fine = ggx_lambert_shares(alpha, views, 10, 40);
        for (std::size_t v = 0; v < views.size(); ++v)
            for (std::size_t k = 0; k < 10; ++k)
                EXPECT_NEAR(coarse[v][k], fine[v][k], 2e-8) << alpha << ' ' << k;
    }
}

TEST(GgxLambert, RefusesWhatItCannotAnswer) {
    std::mt19937_64 random(1);
    for (const double bad : {0., -1., 1.1, std::nan("")}) {
        EXPECT_THROW(ggx_lambert_single_albedo(bad, .5), std::domain_error);
        EXPECT_THROW(ggx_lambert_single(.5, bad, .5, 0), std::domain_error);
        EXPECT_THROW(ggx_lambert_walk(.5, bad, random), std::domain_error);
    }
}

}  // namespace
}  // namespace kiln::reference
