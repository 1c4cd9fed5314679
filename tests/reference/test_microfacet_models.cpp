// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "tests/reference/cosine_average.h"
#include "tests/reference/microfacet_albedo.h"
#include "tests/reference/reference.h"
#include "tests/reference/tanh_sinh.h"

// Every lobe against closed forms, values published elsewhere, the ggx integrals of reference.h and
// a second parameterisation.
namespace kiln::reference {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kLn2 = std::numbers::ln2;
constexpr double kExact = 1e-9;  // stated accuracy of microfacet_albedo()

constexpr Distribution kDistributions[] = {Distribution::ggx, Distribution::beckmann,
                                           Distribution::charlie};
constexpr Microfacet kLobes[] = {
    {Distribution::ggx, Visibility::smith_correlated, 0},
    {Distribution::ggx, Visibility::smith_separable, 0},
    {Distribution::ggx, Visibility::karis_ibl, 0},
    {Distribution::ggx, Visibility::karis_direct, 0},
    {Distribution::ggx, Visibility::unreal_joint, 0},
    {Distribution::ggx, Visibility::neubelt, 0},
    {Distribution::beckmann, Visibility::smith_correlated, 0},
    {Distribution::beckmann, Visibility::smith_separable, 0},
    {Distribution::charlie, Visibility::neubelt, 0},
    {Distribution::charlie, Visibility::charlie, 0},
    {Distribution::charlie, Visibility::charlie_softened, 0},
};

Microfacet with(Microfacet lobe, double alpha) {
    lobe.alpha = alpha;
    return lobe;
}

/// Integral of <w, m> D(m) over all normals, the projected area of the surface seen from w, by the
/// polar angle of m; the azimuth is in closed form.
double projected_area(Distribution kind, double alpha, double cosine) {
    const TanhSinh& rule = tanh_sinh(7);
    const double polar = std::acos(cosine), sine = std::sin(polar);
    double sum = 0;
    for (const auto& [begin, end] : {std::pair{0.0, kPi / 2 - polar}, {kPi / 2 - polar, kPi / 2}})
        for (std::size_t j = 0; j < rule.weight.size(); ++j) {
            const double theta = begin + (end - begin) * rule.from0[j];
            const double c = std::cos(theta), s = std::sin(theta);
            if (s == 0 || c < 1e-12) continue;
            const double turn = std::clamp(-cosine * c / (sine * s), -1.0, 1.0);
            const double phi = sine == 0 ? kPi : std::acos(turn);
            sum += (end - begin) * rule.weight[j] * distribution(kind, alpha, s / c) * s * 2 *
                   (phi * cosine * c + sine * s * std::sin(phi));
        }
    return sum;
}

TEST(MicrofacetModels, DistributionsProjectToOne) {
    for (const Distribution kind : kDistributions)
        for (const double alpha : {.02, .1, .5, 1.})
            EXPECT_NEAR(projected_area(kind, alpha, 1), 1, 1e-10)
                << static_cast<int>(kind) << ' ' << alpha;
}

// Smith's Lambda is by definition what the projected area exceeds the cosine by: cos (1 + Lambda).
TEST(MicrofacetModels, LambdaIsTheHiddenArea) {
    for (const Distribution kind : {Distribution::ggx, Distribution::beckmann})
        for (const double alpha : {.1, .5, 1.})
            for (const double mu : {.05, .3, .8})
                EXPECT_NEAR(mu * (1 + smith_lambda(kind, alpha, mu)),
                            projected_area(kind, alpha, mu), 1e-10)
                    << static_cast<int>(kind) << ' ' << alpha << ' ' << mu;
    EXPECT_EQ(smith_lambda(Distribution::beckmann, .5, 1), 0);
}

// Charlie's Lambda is a fit to that integral, made at either end of alpha and mixed between: where
// the fits stand, alpha = 1 and near 0.1, G1 must be right to 2e-2; between them it is up to 3e-2
// off, and below 0.05 the fit saturates. Digits of its ten constants that were wrong by 1 % each
// would break this, finer errors would not.
TEST(MicrofacetModels, CharlieLambdaIsNearTheHiddenArea) {
    for (const double alpha : {.1, 1.})
        for (const double mu : {.05, .2, .5, .8, .95}) {
            const double exact = mu / projected_area(Distribution::charlie, alpha, mu);
            EXPECT_NEAR(1 / (1 + charlie_lambda(alpha, mu)), exact, 2e-2) << alpha << ' ' << mu;
        }
    const double below = charlie_lambda(.3, std::nextafter(.5, 0)), at = charlie_lambda(.3, .5);
    EXPECT_NEAR(below, at, 1e-12);
}

TEST(MicrofacetModels, AgreesWithTheGgxIntegrals) {
    for (const double alpha : {.02, .1, .5625, 1.})
        for (const double mu : {.02, .1, .5, 1.}) {
            const Microfacet joint{Distribution::ggx, Visibility::smith_correlated, alpha};
            const Microfacet apart{Distribution::ggx, Visibility::smith_separable, alpha};
            EXPECT_NEAR(microfacet_albedo(joint, mu),
                        directional_albedo(mu, alpha, Masking::correlated), kExact);
            EXPECT_NEAR(microfacet_albedo(apart, mu),
                        directional_albedo(mu, alpha, Masking::separable), kExact);
            const GeneralSplitSum sum = microfacet_split_sum(joint, mu);
            const SplitSum expected = split_sum(mu, alpha, Masking::correlated);
            EXPECT_NEAR(sum.scale, expected.scale, kExact);
            EXPECT_NEAR(sum.bias, expected.bias, kExact);
        }
}

// Half-vectors against directions of the light: 1e-8 is what the second states from 0.1 on.
TEST(MicrofacetModels, TwoParameterisationsAgree) {
    for (const Microfacet& model : kLobes)
        for (const double alpha : {.1, .4, 1.})
            for (const double mu : {.05, .4, 1.}) {
                const Microfacet lobe = with(model, alpha);
                EXPECT_NEAR(microfacet_albedo(lobe, mu), microfacet_albedo_over_light(lobe, mu),
                            1e-8)
                    << static_cast<int>(lobe.distribution) << ' '
                    << static_cast<int>(lobe.visibility) << ' ' << alpha << ' ' << mu;
            }
    const Fresnel gold = fresnel_conductor(.18, 3.4);
    const Microfacet lobe{Distribution::beckmann, Visibility::smith_correlated, .3};
    EXPECT_NEAR(microfacet_albedo(lobe, .3, gold), microfacet_albedo_over_light(lobe, .3, gold),
                1e-8);
}

// E and B at (NoV, roughness), six digits, computed elsewhere.
TEST(MicrofacetModels, PublishedMaskings) {
    const double at[5][2] = {{.1, .25}, {.25, .5}, {.5, .75}, {.5, 1}, {1, 1}};
    const struct {
        Visibility visibility;
        double E[5], B[5];
    } rows[] = {
        {Visibility::smith_correlated,
         {.896770, .840082, .663176, .450694, .306853},
         {.391622, .080828, .008483, .002989, .000034}},
        {Visibility::smith_separable,
         {.892473, .828512, .647443, .409137, .306853},
         {.389015, .078369, .007974, .002456, .000034}},
        {Visibility::karis_ibl,
         {.682358, .670296, .579982, .409137, .306853},
         {.291091, .060884, .006970, .002456, .000034}},
        {Visibility::karis_direct,
         {.196399, .433877, .508007, .409137, .306853},
         {.074426, .034947, .005671, .002456, .000034}},
        {Visibility::unreal_joint,
         {.705194, .697434, .603249, .450694, .306853},
         {.303538, .065744, .007654, .002989, .000034}},
    };
    for (const auto& row : rows)
        for (int i = 0; i < 5; ++i) {
            const Microfacet lobe{Distribution::ggx, row.visibility, at[i][1] * at[i][1]};
            EXPECT_NEAR(microfacet_albedo(lobe, at[i][0]), row.E[i], 5.1e-7) << i;
            EXPECT_NEAR(microfacet_split_sum(lobe, at[i][0]).bias, row.B[i], 5.1e-7) << i;
        }
    const double mu[] = {.05, .25, .5, .75, 1},
                 sheen[] = {.747070, .431368, .229553, .107748, .031250};
    for (int i = 0; i < 5; ++i)
        EXPECT_NEAR(microfacet_albedo({Distribution::charlie, Visibility::neubelt, .25}, mu[i]),
                    sheen[i], 1.1e-6);
    EXPECT_NEAR(microfacet_albedo({Distribution::charlie, Visibility::neubelt, 1. / 16}, .05), 1.13,
                5.1e-3);
}

// Albedos under exact Fresnel, fifteen digits, computed elsewhere; one with total reflection.
TEST(MicrofacetModels, PublishedFresnelAlbedos) {
    const auto albedo = [](double mu, double alpha, const Fresnel& fresnel) {
        return microfacet_albedo({Distribution::ggx, Visibility::smith_correlated, alpha}, mu,
                                 fresnel);
    };
    EXPECT_NEAR(albedo(.5, .25, fresnel_dielectric(1 / 1.5)), .7242980403387987, kExact);
    EXPECT_NEAR(albedo(.1, .01, fresnel_dielectric(1.5)), .5606928591947141, kExact);
    EXPECT_NEAR(albedo(.5, .25, fresnel_dielectric(1.5)), .06689850709319349, kExact);
    EXPECT_NEAR(albedo(.1, .25, fresnel_dielectric(1.5)), .1718396987451538, kExact);
    EXPECT_NEAR(albedo(1, 1, fresnel_dielectric(1.5)), .012702412787269034, kExact);
    EXPECT_NEAR(albedo(.1, .25, fresnel_conductor(.18, 3.4)), .8404943404865305, kExact);
    EXPECT_NEAR(albedo(1, 1, fresnel_conductor(.18, 3.4)), .2896979825587221, kExact);
}

TEST(MicrofacetModels, ClosedForms) {
    for (const double mu : {.02, .3, 1.}) {
        EXPECT_NEAR(microfacet_albedo({Distribution::ggx, Visibility::smith_correlated, 1}, mu),
                    1 - mu * std::log1p(1 / mu), kExact);
        EXPECT_NEAR(microfacet_albedo({Distribution::ggx, Visibility::smith_separable, 1}, mu),
                    2 * (1 - kLn2) / (1 + mu), kExact);
    }
    // At NoV = 1 Neubelt's V is 1/4, and E the integral of D cos(theta) cos(2 theta).
    EXPECT_NEAR(microfacet_albedo({Distribution::ggx, Visibility::neubelt, 1}, 1), .25, kExact);
    for (const double alpha : {.1, .25, .7, 1.}) {
        const double n = 1 / alpha;
        EXPECT_NEAR(microfacet_albedo({Distribution::charlie, Visibility::neubelt, alpha}, 1),
                    2 / (n + 4) * std::exp2(-(n + 2) / 2), kExact);
    }
    // Under a lobe as narrow as this the mirror reflects: all, or F.
    const Microfacet narrow{Distribution::beckmann, Visibility::smith_correlated, .02};
    EXPECT_NEAR(microfacet_albedo(narrow, .5), 1, kExact);
    EXPECT_NEAR(microfacet_albedo(narrow, .9, fresnel_dielectric(1.5)),
                fresnel_dielectric(1.5).at(.9), 1e-4);
}

TEST(MicrofacetModels, AnySchlickIsLinearInItsEnds) {
    for (const double exponent : {1., 3., 5., 7.5}) {
        const Microfacet lobe{Distribution::beckmann, Visibility::smith_separable, .3};
        const GeneralSplitSum sum = microfacet_split_sum(lobe, .3, exponent);
        EXPECT_NEAR(sum.scale + sum.bias, microfacet_albedo(lobe, .3), kExact);
        EXPECT_NEAR(microfacet_albedo(lobe, .3, fresnel_schlick(.2, .7, exponent)),
                    .2 * sum.scale + .7 * sum.bias, kExact);
    }
}

TEST(MicrofacetModels, Averages) {
    for (const double alpha : {.1, 1.}) {
        EXPECT_NEAR(microfacet_average({Distribution::ggx, Visibility::smith_correlated, alpha}),
                    average_albedo(alpha, Masking::correlated), 1e-8);
        EXPECT_NEAR(microfacet_average({Distribution::ggx, Visibility::smith_separable, alpha}),
                    average_albedo(alpha, Masking::separable), 1e-8);
    }
    // A midpoint rule in NoV^2 for two others: 64 points of a curve with a vertical tangent at 0
    // leave 64^-1.5 = 2e-3 of its drop there, which is about a half.
    for (const Microfacet& lobe : {Microfacet{Distribution::beckmann, Visibility::neubelt, .4},
                                   {Distribution::charlie, Visibility::neubelt, .4}}) {
        double sum = 0;
        for (int i = 0; i < 64; ++i) sum += microfacet_albedo(lobe, std::sqrt((i + .5) / 64));
        EXPECT_NEAR(microfacet_average(lobe), sum / 64, 1e-3)
            << static_cast<int>(lobe.distribution);
    }
    // With a kink where it is told: 2 * integral of |mu - 1/2| mu = 1/4.
    EXPECT_NEAR(cosine_average([](double mu) { return std::abs(mu - .5); }, {.5}, 1e-6), .25, 1e-8);
}

TEST(MicrofacetModels, OnlyTheSoftenedTerminatorIsNotReciprocal) {
    for (const Microfacet& model : kLobes) {
        const Microfacet lobe = with(model, .3);
        const double there = visibility(lobe, .2, .7), back = visibility(lobe, .7, .2);
        if (lobe.visibility == Visibility::charlie_softened) {
            EXPECT_GT(std::abs(there / back - 1), .1);
            // Toward light from above the exponent is 1.
            EXPECT_DOUBLE_EQ(visibility(lobe, .2, 1),
                             visibility({Distribution::charlie, Visibility::charlie, .3}, .2, 1));
        } else {
            EXPECT_NEAR(there / back, 1, 1e-14) << static_cast<int>(lobe.visibility);
        }
    }
}

TEST(MicrofacetModels, RefusesWhatItCannotAnswer) {
    const auto albedo = [](Distribution d, Visibility v, double alpha, double mu) {
        return microfacet_albedo({d, v, alpha}, mu);
    };
    EXPECT_THROW(albedo(Distribution::charlie, Visibility::smith_correlated, .5, .5),
                 std::domain_error);
    EXPECT_THROW(albedo(Distribution::ggx, Visibility::charlie, .5, .5), std::domain_error);
    for (const double bad : {0., -1., 1.1, std::nan("")}) {
        EXPECT_THROW(albedo(Distribution::ggx, Visibility::neubelt, bad, .5), std::domain_error);
        EXPECT_THROW(albedo(Distribution::ggx, Visibility::neubelt, .5, bad), std::domain_error);
    }
    EXPECT_THROW(microfacet_albedo({Distribution::ggx, Visibility::neubelt, .5}, .5,
                                   {[](double) { return std::nan(""); }, {}}),
                 std::domain_error);
}

}  // namespace
}  // namespace kiln::reference
