// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/reference/coupling_models.h"

// White-furnace values of whole materials: identities, closed forms, and the verdicts that tell the
// couplings apart.
namespace kiln::reference {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kExact = 1e-7;  // stated accuracy of Material::total()
constexpr Diffuse kWhite{DiffuseModel::lambert, 0, 1};

Microfacet ggx(double alpha) { return {Distribution::ggx, Visibility::smith_correlated, alpha}; }

// Each bounce after the first is met by the surface again with share 1 - E_avg and colours by F.
TEST(CouplingModels, KullaContyFactorIsTheSumOfBounces) {
    for (const double E : {.4, .9, .999})
        for (const double F : {.05, .6, 1.}) {
            double sum = 0, term = F * F * E;
            for (int k = 1; k < 200; ++k, term *= F * (1 - E)) sum += term;
            EXPECT_NEAR(kulla_conty_factor(E, F, 2), sum, 1e-14);
            EXPECT_NEAR(kulla_conty_factor(E, F, 1) * F, sum, 1e-14);
        }
}

TEST(CouplingModels, CompensatedLobesCloseTheFurnace) {
    for (const auto compensation : {Multiscatter::kulla_conty,
                                    Multiscatter::kulla_conty_first_power, Multiscatter::turquin}) {
        const SpecularAlbedo white({ggx(.4), fresnel_none(), compensation});
        const SpecularAlbedo grey({ggx(.4), fresnel_schlick(.5), compensation});
        for (const double mu : {.05, .4, 1.}) {
            EXPECT_NEAR(white.at(mu), 1, kExact);
            EXPECT_NEAR(grey.white(mu), 1, kExact);
            const double plain = microfacet_albedo(ggx(.4), mu, fresnel_schlick(.5));
            EXPECT_GT(grey.at(mu), plain);
            EXPECT_LT(grey.at(mu), 1);
        }
    }
}

// Both compensations from the figures published for ggx: E_avg .8823233826182513 at alpha = .25,
// albedo and F_avg of the conductor .18 + 3.4 i, E at NoV = .5 and .1.
TEST(CouplingModels, CompensationFromPublishedFigures) {
    const double E_avg = .8823233826182513, F_avg = .9425768285986023;
    const double share = F_avg * E_avg / (1 - F_avg * (1 - E_avg));
    const struct {
        double mu, E, albedo;
    } at[] = {{.5, .8572634355815696, .8063285627056721},
              {.1, .8916223518094879, .8404943404865305}};
    const Fresnel metal = fresnel_conductor(.18, 3.4);
    const SpecularAlbedo square({ggx(.25), metal, Multiscatter::kulla_conty});
    const SpecularAlbedo first({ggx(.25), metal, Multiscatter::kulla_conty_first_power});
    const SpecularAlbedo turquin({ggx(.25), metal, Multiscatter::turquin});
    const double F0 = (.82 * .82 + 3.4 * 3.4) / (1.18 * 1.18 + 3.4 * 3.4);
    for (const auto& a : at) {
        EXPECT_NEAR(square.at(a.mu), a.albedo + share * F_avg * (1 - a.E), 1e-8);
        EXPECT_NEAR(first.at(a.mu), a.albedo + share * (1 - a.E), 1e-8);
        EXPECT_NEAR(turquin.at(a.mu), a.albedo * (1 + F0 * (1 - a.E) / a.E), 1e-8);
    }
}

// The four verdicts on white Lambert under glass: a sum gains all that it adds, the half-vector
// gains toward grazing, the view loses what the lobe misses, Kelemen's closes the furnace.
TEST(CouplingModels, Verdicts) {
    const Specular glass{ggx(.25), fresnel_dielectric(1.5)};
    const auto total = [&](Coupling coupling, double mu) {
        return Material(coupling, glass, kWhite).total(mu);
    };
    for (const double mu : {.05, .25, .5, .75, 1.}) {
        const double E = microfacet_albedo(ggx(.25), mu), F = glass.fresnel.at(mu);
        EXPECT_NEAR(total(Coupling::none, mu), 1 + microfacet_albedo(ggx(.25), mu, glass.fresnel),
                    kExact);
        EXPECT_NEAR(total(Coupling::view, mu), 1 - F * (1 - E), kExact);
        EXPECT_LT(total(Coupling::view, mu), 1);
        EXPECT_NEAR(total(Coupling::kelemen, mu), 1, kExact);
    }
    EXPECT_GT(total(Coupling::half_vector, .05), 1.1);
    EXPECT_GT(total(Coupling::half_vector, .25), 1.05);
    EXPECT_LT(total(Coupling::half_vector, 1), 1);
    const Material blended(Coupling::view,
                           {ggx(.25), fresnel_dielectric(1.5), Multiscatter::kulla_conty}, kWhite);
    EXPECT_NEAR(blended.total(.2), 1, kExact);
}

// Seen from above, VoH^2 = (1 + NoL) / 2, and the diffuse share that Schlick's Fresnel takes is an
// integral of a polynomial in h = VoH: 8 h (2 h^2 - 1) (F0 + (1 - F0) (1 - h)^5) on [1/sqrt 2, 1].
// Simpson with 1000 panels leaves 1e-12.
TEST(CouplingModels, HalfVectorSeenFromAbove) {
    const auto taken = [](double h) {
        return 8 * h * (2 * h * h - 1) * (.04 + .96 * std::pow(1 - h, 5));
    };
    constexpr int n = 1000;
    const double from = std::numbers::sqrt2 / 2, step = (1 - from) / n;
    double sum = taken(from) + taken(1);
    for (int i = 1; i < n; ++i) sum += (i % 2 == 1 ? 4 : 2) * taken(from + i * step);
    const Material material(Coupling::half_vector, {ggx(.3), fresnel_schlick(.04)},
                            {DiffuseModel::lambert, 0, .6});
    EXPECT_NEAR(material.total(1),
                .6 * (1 - sum * step / 3) + microfacet_albedo(ggx(.3), 1, fresnel_schlick(.04)),
                kExact);
}

// With total reflection, against a midpoint rule of n x n points that knows nothing of the kink:
// the slope there is infinite, which leaves n^-1.5 = 1e-4.
TEST(CouplingModels, HalfVectorInsideTheDenserMedium) {
    const Fresnel inside = fresnel_dielectric(1 / 1.5);
    const Diffuse rough{DiffuseModel::burley, .8, .9};
    constexpr int n = 500;
    const double mu = .4, sine = std::sqrt(1 - mu * mu);
    double sum = 0;
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
            const double l = std::sqrt((i + .5) / n), c = std::cos(kPi * (j + .5) / n);
            const double VoH = std::sqrt((1 + mu * l + sine * std::sqrt(1 - l * l) * c) / 2);
            sum += diffuse_brdf(rough, mu, l, c) * (1 - inside.at(VoH));
        }
    const double expected = kPi * sum / (n * n) + microfacet_albedo(ggx(.25), mu, inside);
    EXPECT_NEAR(Material(Coupling::half_vector, {ggx(.25), inside}, rough).total(mu), expected,
                1e-4);
}

// sigma = 0 is Lambert by another road: the integral of f_d (1 - E(L)) that the identity spares.
TEST(CouplingModels, KelemenByQuadratureIsTheIdentity) {
    const Specular coat{{Distribution::ggx, Visibility::karis_ibl, .3}, fresnel_schlick(.2)};
    const Material material(Coupling::kelemen, coat, {DiffuseModel::oren_nayar, 0, .7});
    const double E = microfacet_albedo(coat.lobe, .3, coat.fresnel);
    EXPECT_NEAR(material.total(.3), E + .7 * (1 - E), kExact);
}

// A specular lobe that reflects all leaves the diffuse one nothing; one that reflects nothing
// leaves it all.
TEST(CouplingModels, EndsOfTheSpecularLobe) {
    const Microfacet lobe{Distribution::ggx, Visibility::karis_ibl, .5};
    const Diffuse rough{DiffuseModel::fon, .7, .8};
    const Material full(Coupling::kelemen, {lobe, fresnel_none(), Multiscatter::turquin}, rough);
    EXPECT_NEAR(full.total(.3), 1, kExact);
    for (const auto coupling :
         {Coupling::none, Coupling::half_vector, Coupling::view, Coupling::kelemen}) {
        const Material bare(coupling, {lobe, fresnel_schlick(0, 0)}, rough);
        EXPECT_NEAR(bare.total(.3), .8 * fon_albedo(.7, .3), kExact);
    }
}

}  // namespace
}  // namespace kiln::reference
