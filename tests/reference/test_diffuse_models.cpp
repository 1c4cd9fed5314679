// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/reference/diffuse_models.h"

// Diffuse lobes against published albedos, closed forms and integrals by other means.
namespace kiln::reference {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kExact = 1e-9;  // stated accuracy of diffuse_albedo()
constexpr double kC1 = .5 - 2 / (3 * kPi), kC2 = 2.0 / 3 - 28 / (15 * kPi);

// Values computed elsewhere; the last of six digits may be off by one.
TEST(DiffuseModels, PublishedAlbedos) {
    const double mu[] = {.05, .25, .5, .75, 1};
    const struct {
        Diffuse lobe;
        double albedo[5];
        double last_mu;
    } rows[] = {
        {{DiffuseModel::burley, 0}, {.598512, .860363, .960938, .975714, .976190}, 1},
        {{DiffuseModel::burley, .5}, {1.017407, 1.022492, 1.008320, 1.004711, 1.005952}, 1},
        {{DiffuseModel::burley, 1}, {1.463614, 1.193435, 1.056904, 1.033747, 1.035714}, 1},
        {{DiffuseModel::oren_nayar, .5}, {.944459, .919309, .883128, .844277, .784483}, 1},
        {{DiffuseModel::eon, 1, .8}, {.797669, .787696, .775124, .764510, .758723}, 1},
        {{DiffuseModel::eon_unreal, 1}, {1.017546, 1.004249, .987054, .980462, 1}, 1},
        {{DiffuseModel::chan2024, .5}, {.989417, .959810, .955824, .963735, .976835}, .999},
        {{DiffuseModel::chan2024, 1}, {.993537, .947482, .941282, .953587, .973966}, .999},
        {{DiffuseModel::chan2018, 1}, {1.066229, .972182, .938888, .947570, .973097}, .999},
    };
    for (const auto& row : rows)
        for (int i = 0; i < 5; ++i)
            EXPECT_NEAR(diffuse_albedo(row.lobe, i < 4 ? mu[i] : row.last_mu), row.albedo[i],
                        1.1e-6)
                << static_cast<int>(row.lobe.model) << ' ' << mu[i];
    EXPECT_NEAR(diffuse_albedo({DiffuseModel::chan2018, .02}, .05), .405, 5.1e-4);
}

TEST(DiffuseModels, PublishedAlbedosToTheLastDigit) {
    const struct {
        Diffuse lobe;
        double mu, albedo;
    } spots[] = {
        {{DiffuseModel::burley, 1}, .1, 1.3801258410714285},
        {{DiffuseModel::burley, .25}, .5, .9844786628844246},
        {{DiffuseModel::burley, 1}, 1, 1.0357142857142858},
        {{DiffuseModel::eon, .5, .8}, .1, .7974975692390922},
        {{DiffuseModel::eon, .5, .8}, 1, .778234047052139},
        {{DiffuseModel::eon, 1, .5}, .5, .4632584949807224},
        {{DiffuseModel::eon, .25, .18}, .01, .17988893441269915},
        {{DiffuseModel::oren_nayar, 1}, .1, .8163830098637354},
        {{DiffuseModel::oren_nayar, 1}, .5, .7471409754343431},
        {{DiffuseModel::oren_nayar_full, 1}, .1, .8924512228256967},
        {{DiffuseModel::oren_nayar_full, 1, .5}, .5, .3687814154128256},
    };
    for (const auto& s : spots)
        EXPECT_NEAR(diffuse_albedo(s.lobe, s.mu), s.albedo, kExact)
            << static_cast<int>(s.lobe.model) << ' ' << s.mu;
    // Toward grazing view, where Burley's and Oren and Nayar's lobes gain energy.
    EXPECT_NEAR(diffuse_albedo({DiffuseModel::burley, 1}, 1e-5), 1.557540, 3e-5);
    EXPECT_NEAR(diffuse_albedo({DiffuseModel::burley, .5}, 1e-5), 1.005456, 3e-5);
    EXPECT_NEAR(diffuse_albedo({DiffuseModel::oren_nayar_full, .3}, 1e-4), 1.051, 1e-3);
    EXPECT_NEAR(diffuse_albedo({DiffuseModel::oren_nayar, .2}, 1e-4), 1.015, 1e-3);
}

/// Burley's albedo with the azimuth averaged by hand: with f90 - 1 = p + q cos(phi), the means of
/// the first and second powers are p and p^2 + q^2 / 2. A polynomial in NoL: Simpson on 4096
/// panels leaves 1e-13.
double burley_albedo(double r, double mu) {
    const auto fade = [](double c) { return std::pow(1 - c, 5); };
    const auto ring = [&](double l) {
        const double p = r * (1 + mu * l) - .5;
        const double q2 = r * r * (1 - mu * mu) * (1 - l * l);
        return l * (1 + p * (fade(l) + fade(mu)) + (p * p + q2 / 2) * fade(l) * fade(mu));
    };
    constexpr int n = 4096;
    double sum = ring(0) + ring(1);
    for (int i = 1; i < n; ++i) sum += (i % 2 == 1 ? 4 : 2) * ring(double(i) / n);
    return 2 * sum / (3 * n);
}

TEST(DiffuseModels, ClosedForms) {
    for (const double mu : {.01, .2, .6, .95, 1.}) {
        for (const double r : {0., .3, 1.}) {
            EXPECT_NEAR(diffuse_albedo({DiffuseModel::burley, r, .7}, mu),
                        .7 * burley_albedo(r, mu), kExact);
            EXPECT_NEAR(diffuse_albedo({DiffuseModel::fon, r, .7}, mu), .7 * fon_albedo(r, mu),
                        kExact)
                << r << ' ' << mu;
            EXPECT_NEAR(diffuse_albedo({DiffuseModel::eon, r}, mu), 1, kExact) << r << ' ' << mu;
            const double average = (1 + kC2 * r) / (1 + kC1 * r), e = fon_albedo(r, mu);
            EXPECT_NEAR(diffuse_albedo({DiffuseModel::eon, r, .6}, mu),
                        .6 * e + .36 * average / (1 - .6 * (1 - average)) * (1 - e), kExact);
        }
        EXPECT_NEAR(diffuse_albedo({DiffuseModel::lambert, 0, .3}, mu), .3, kExact);
        EXPECT_NEAR(diffuse_albedo({DiffuseModel::oren_nayar, 0, .3}, mu), .3, kExact);
        EXPECT_NEAR(diffuse_albedo({DiffuseModel::oren_nayar_full, 0, .3}, mu), .3, kExact);
        EXPECT_NEAR(diffuse_albedo({DiffuseModel::chan2024, 0, .3}, mu), .3, kExact);
    }
    EXPECT_NEAR(diffuse_albedo({DiffuseModel::fon, .4}, 1), 1 / (1 + kC1 * .4), kExact);
    EXPECT_NEAR(fon_albedo(.4, 1e-5), 1, 1e-4);
    EXPECT_NEAR(diffuse_albedo({DiffuseModel::oren_nayar, .7}, 1), 1 - .49 / (2 * (.49 + .33)),
                kExact);
}

TEST(DiffuseModels, AveragesOfFonAndBurley) {
    EXPECT_NEAR(diffuse_average({DiffuseModel::fon, .6}), (1 + kC2 * .6) / (1 + kC1 * .6), 1e-7);
    // At r = 0: 2 * integral of (1 - (1 - m)^5 / 2) m = 1 - 1/42, squared.
    EXPECT_NEAR(diffuse_average({DiffuseModel::burley, 0}), 41.0 * 41 / (42 * 42), 1e-7);
}

// A midpoint rule over NoL and the azimuth that knows no kink: a jump of slope leaves 1/n^2 times
// the jump, of the order of 1. chan2018's clamp is one of those kinks, and not splitting at it
// costs 7e-6 at NoV = .02.
TEST(DiffuseModels, KinksAreSplitWhereTheyAre) {
    const auto brute = [](const Diffuse& lobe, double mu, int n = 500) {
        double sum = 0;
        for (int i = 0; i < n; ++i)
            for (int j = 0; j < n; ++j) {
                const double NoL = (i + .5) / n;
                sum += 2 * NoL * diffuse_brdf(lobe, mu, NoL, std::cos(kPi * (j + .5) / n));
            }
        return kPi * sum / (1.0 * n * n);
    };
    const Diffuse roughest{DiffuseModel::chan2018, 1};
    EXPECT_NEAR(diffuse_albedo(roughest, .02), brute(roughest, .02, 2000), 2e-6);
    for (const Diffuse& lobe : {roughest,
                                {DiffuseModel::chan2018, .6},
                                {DiffuseModel::chan2024, .4},
                                {DiffuseModel::oren_nayar_full, .6}})
        for (const double mu : {.1, .6})
            EXPECT_NEAR(diffuse_albedo(lobe, mu), brute(lobe, mu), 2e-5)
                << static_cast<int>(lobe.model) << ' ' << mu;
    EXPECT_LT(diffuse_albedo({DiffuseModel::chan2018, 1}, .05),
              diffuse_albedo({DiffuseModel::chan2018_no_clamp, 1}, .05) - 1e-3);
}

TEST(DiffuseModels, AllAreReciprocalButUnreals) {
    for (int m = 0; m <= static_cast<int>(DiffuseModel::chan2024); ++m) {
        const Diffuse lobe{static_cast<DiffuseModel>(m), .7, .9};
        const double there = diffuse_brdf(lobe, .2, .9, -.3),
                     back = diffuse_brdf(lobe, .9, .2, -.3);
        if (lobe.model == DiffuseModel::eon_unreal)
            EXPECT_GT(std::abs(there - back), 1e-3);
        else
            EXPECT_NEAR(there, back, 1e-15) << m;
    }
}

// (1 - F(VoH)) with a kink of total reflection, whose integral is known: Lambert under light from V
// mirrored, VoH = cos of half the angle to L. At NoV = 1, VoH^2 = (1 + NoL) / 2, so a step at u
// leaves the integral of 2 NoL above 2 u^2 - 1.
TEST(DiffuseModels, WeightsAreSplitAtTheirKinks) {
    const double u = .8, from = 2 * u * u - 1;
    const DiffuseWeight step{[&](double, double VoH) { return VoH > u ? 1.0 : 0.0; }, {u}, {}};
    EXPECT_NEAR(diffuse_integral({DiffuseModel::lambert}, 1, step), 1 - from * from, kExact);
    const DiffuseWeight light{[&](double NoL, double) { return NoL > .6 ? 1.0 : 0.0; }, {}, {.6}};
    EXPECT_NEAR(diffuse_integral({DiffuseModel::lambert}, .4, light), 1 - .36, kExact);
    // A cap of half-angle 2 acos(u) about V that the horizon does not cut: by symmetry about V,
    // NoL averages to NoV (V.L), so the integral is 1/pi * 2 pi * NoV * (1 - from^2) / 2.
    EXPECT_NEAR(diffuse_integral({DiffuseModel::lambert}, .97, step), .97 * (1 - from * from),
                kExact);
    EXPECT_THROW(diffuse_albedo({DiffuseModel::lambert}, 0), std::domain_error);
    EXPECT_THROW(diffuse_albedo({DiffuseModel::lambert}, std::nan("")), std::domain_error);
}

}  // namespace
}  // namespace kiln::reference
