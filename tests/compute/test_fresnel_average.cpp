// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "server/base/error.h"
#include "server/compute/fresnel.h"
#include "server/spec/metals.h"
#include "tests/kernels/textbook_fresnel.h"
#include "tests/reference/tanh_sinh.h"

namespace kiln {
namespace {

FresnelModel dielectric(double ior) {
    FresnelModel model{.model = Fresnel::dielectric};
    model.ior = {ior};
    return model;
}

FresnelModel conductor(double eta, double k) {
    FresnelModel model{.model = Fresnel::conductor};
    model.eta = {eta};
    model.k = {k};
    return model;
}

FresnelModel edge_tint(double reflectivity, double tint) {
    FresnelModel model{.model = Fresnel::edge_tint};
    model.reflectivity = {reflectivity};
    model.edge_tint = {tint};
    return model;
}

/// 2 ∫ F(μ) μ dμ by tanh-sinh on either side of `split`, to 1e-14 by its own estimate.
template <class F>
double quadrature(const F& f, double split) {
    return reference::converge(
        [&](int level) {
            const auto& rule = reference::tanh_sinh(level);
            double sum = 0;
            for (std::size_t i = 0; i < rule.weight.size(); ++i) {
                const double left = split * rule.from0[i],
                             right = split + (1 - split) * rule.from0[i];
                sum +=
                    rule.weight[i] * 2 * (split * left * f(left) + (1 - split) * right * f(right));
            }
            return sum;
        },
        1e-14, 0, reference::Magnitude{}, 5);
}

double textbook_average(std::complex<textbook::Extended> index, double split) {
    return quadrature([&](double mu) { return static_cast<double>(textbook::fresnel(index, mu)); },
                      split);
}

TEST(FresnelAverage, SchlickIsItsClosedForm) {
    FresnelModel model{.model = Fresnel::schlick};
    model.f0 = {0.2, 0.5, 0.9};
    model.f90 = {1};
    EXPECT_EQ(channel_count(model), 3);
    EXPECT_DOUBLE_EQ(fresnel_average(model, 1), 0.5 + 0.5 / 21);
    for (const double exponent : {0.3, 1.0, 5.0, 8.5}) {
        model.exponent = exponent;
        EXPECT_NEAR(
            fresnel_average(model, 2),
            quadrature([&](double mu) { return 0.9 + 0.1 * std::pow(1 - mu, exponent); }, 0.5),
            1e-13)
            << exponent;
    }
}

TEST(FresnelAverage, AgreesWithPublishedFigures) {
    EXPECT_NEAR(fresnel_average(dielectric(1.5), 0), 0.09177795934235122, 1e-15);
    EXPECT_NEAR(fresnel_average(conductor(0.18, 3.4), 0), 0.9425768285986023, 1e-12);
    EXPECT_NEAR(fresnel_average(dielectric(1.33), 0), 0.065931, 5e-7);
    EXPECT_NEAR(fresnel_average(dielectric(2.4), 0), 0.210181, 5e-7);
    EXPECT_NEAR(fresnel_average(dielectric(1 / 1.5), 0), 0.596346, 5e-7);
}

TEST(FresnelAverage, DielectricAgreesWithQuadrature) {
    EXPECT_EQ(fresnel_average(dielectric(1), 0), 0.0);
    for (const double ior : {1e-4, 0.1, 1 / 2.4, 1 / 1.33, 0.99, 1 / 1.005, 1 - 1e-5, 1 + 1e-5,
                             1.001, 1.0099999, 1.01, 1.05, 1.5, 3.0, 10.0, 50.0}) {
        // The rim of total reflection, the scale of F near η = 1, or its dip at grazing.
        const double split = ior < 1.4 ? std::sqrt(std::abs((ior - 1) * (ior + 1))) : 1 / ior;
        EXPECT_NEAR(fresnel_average(dielectric(ior), 0), textbook_average(ior, split), 1e-12)
            << ior;
    }
    // 1 − F → 4 u n / (1 + u n)² … of a huge index: the average of 1 − F is 8 / (3 n) + O(ln n /
    // n²) for s and 8 / n for p: half their sum, 16 / (3 n).
    EXPECT_NEAR(fresnel_average(dielectric(1e6), 0), 1 - 16e-6 / 3, 1e-9);
}

TEST(FresnelAverage, ConductorAgreesWithQuadrature) {
    const double pairs[][3] = {
        // eta, k, and where F has its kink, else 1/2
        {0.18, 3.4, 0.5}, {1.5, 7.6, 0.5}, {3.2, 3.3, 0.5},     {0.05, 2, 0.5},   {1e-4, 5, 0.5},
        {0, 3, 0.5},      {1.5, 0, 0.5},   {1, 0.01, 0.1},      {0.6, 1e-7, 0.8}, {0.6, 0.01, 0.8},
        {30, 30, 0.03},   {0.8, 0, 0.6},   {1e-4, 1e-4, 0.9999}};
    for (const auto& [eta, k, kink] : pairs)
        EXPECT_NEAR(fresnel_average(conductor(eta, k), 0), textbook_average({eta, k}, kink), 1e-11)
            << eta << " + i " << k;
}

TEST(FresnelAverage, F82TintAgreesWithQuadrature) {
    FresnelModel model{.model = Fresnel::f82_tint};
    model.f0 = {0.7};
    model.f82 = {0.4};
    const auto schlick = [](double mu) { return 0.7 + 0.3 * std::pow(1 - mu, 5); };
    const double b = schlick(1.0 / 7) * 0.6 * 7 / std::pow(6.0 / 7, 6);
    EXPECT_NEAR(
        fresnel_average(model, 0),
        quadrature([&](double mu) { return schlick(mu) - b * mu * std::pow(1 - mu, 6); }, 0.5),
        1e-14);
}

TEST(F82Tint, IsNegativeOnlyBelowItsLeast) {
    const auto lowest = [](double f0, double f82) {
        FresnelModel model{.model = Fresnel::f82_tint};
        model.f0 = {f0};
        model.f82 = {f82};
        double least = 1;
        for (int i = 0; i <= 1000; ++i) least = std::min(least, fresnel(model, 0, i / 1000.0));
        return least;
    };
    for (const double f0 : {0.0, 0.04, 0.3, 0.7, 0.95}) {
        const double f82 = f82_least(f0);
        ASSERT_GT(f82, 0);
        // A step of 1e-3 sees the minimum within its square times half the curvature, < 20.
        EXPECT_NEAR(lowest(f0, f82), 0, 1e-5) << f0;
        EXPECT_GE(lowest(f0, f82), -1e-15) << f0;
        EXPECT_LT(lowest(f0, 0.9 * f82), -1e-6) << f0;
        EXPECT_GT(lowest(f0, 0), -0.13) << f0;
    }
}

TEST(EdgeTint, IsGulbrandsensPair) {
    for (const double r : {0.02, 0.5, 0.9, 0.999})
        for (const double g : {0.0, 0.2, 0.7, 1.0}) {
            const auto [eta, k] = index_from_edge_tint(r, g);
            const double root = std::sqrt(r);
            const double expected = g * (1 - r) / (1 + r) + (1 - g) * (1 + root) / (1 - root);
            EXPECT_NEAR(eta / expected, 1, 1e-12);
            const double k2 = ((eta + 1) * (eta + 1) * r - (eta - 1) * (eta - 1)) / (1 - r);
            // The textbook's difference of squares of size (eta + 1)² loses what they have in
            // common.
            EXPECT_NEAR(k * k, k2, 4e-16 * (eta + 1) * (eta + 1) / (1 - r));
            // And whatever the tint, normal incidence reflects r.
            EXPECT_NEAR(fresnel(edge_tint(r, g), 0, 1), r, 1e-12);
        }
    EXPECT_EQ(index_from_edge_tint(0.9, 0).k, 0);
    EXPECT_EQ(fresnel(edge_tint(0, 0.5), 0, 0.3), 0);
}

void expect_refused(const FresnelModel& model, const char* word) {
    try {
        fresnel_parameters(model, 0);
        ADD_FAILURE() << "accepted: " << word;
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), "fresnel_range");
        EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
    }
}

TEST(FresnelParameters, OutOfRangeAreRefusedByName) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    expect_refused(dielectric(0), "ior is 0.0, it must lie in [0.0001, 1000000.0]");
    expect_refused(dielectric(nan), "ior");
    expect_refused(conductor(1e10, 1e10), "eta is 10000000000.0");
    expect_refused(conductor(1, 2e6), "k is 2000000.0");
    expect_refused(conductor(0, 0), "max(eta, k)");
    expect_refused(conductor(-1, 1), "eta");
    expect_refused(FresnelModel{.model = Fresnel::conductor}, "eta must have 1 value or 3");
    expect_refused(edge_tint(1, 0.5), "reflectivity is 1.0, it must lie in [0.0, 0.99999]");
    expect_refused(edge_tint(0.5, 1.5), "edge_tint");
    FresnelModel schlick{.model = Fresnel::schlick};
    schlick.exponent = 0;
    expect_refused(schlick, "exponent must be above 0");
    schlick.exponent = nan;
    expect_refused(schlick, "exponent");
    schlick.exponent = 5;
    schlick.f90 = {1.5};
    expect_refused(schlick, "f90 is 1.5, it must lie in [0.0, 1.0]");
    schlick.f90 = {1, 1};
    expect_refused(schlick, "f90 must have 1 value or 3, it has 2");
    EXPECT_THROW(fresnel_parameters(dielectric(1.5), 3), Error);
}

// Reflectances at normal incidence in linear sRGB under D65, as another integration over the same
// spectra has them, to three decimals.
constexpr struct {
    Metal metal;
    double f0[3];
} kPublished[] = {
    {Metal::aluminium, {.907, .916, .922}}, {Metal::chromium, {.550, .556, .554}},
    {Metal::copper, {.932, .623, .522}},    {Metal::gold, {1.037, .728, .365}},
    {Metal::iron, {.530, .513, .494}},      {Metal::nickel, {.697, .640, .563}},
    {Metal::platinum, {.678, .638, .584}},  {Metal::silver, {.989, .984, .978}},
    {Metal::titanium, {.619, .579, .543}},  {Metal::tungsten, {.516, .496, .467}},
};

TEST(Metals, HaveTheColourOfTheirSpectrum) {
    for (const auto& [metal, f0] : kPublished) {
        FresnelModel model{.model = Fresnel::conductor};
        model.metal = metal;
        const MetalConstants& constants = metal_constants(metal);
        EXPECT_EQ(constants.metal, metal);
        EXPECT_EQ(channel_count(model), 3);
        for (int c = 0; c < 3; ++c) {
            const auto channel = static_cast<std::size_t>(c);
            // The third decimal of either integration.
            EXPECT_NEAR(constants.f0[channel], f0[channel], 1.1e-3) << constants.source;
            const double reflected = fresnel(model, c, 1);
            if (constants.f0[channel] > 1)  // gold's red: as much as gold reflects, at 700 nm
                EXPECT_NEAR(reflected, 0.97, 0.005);
            else  // four decimals of f0, and five of eta and k
                EXPECT_NEAR(reflected, constants.f0[channel], 7e-5) << constants.source << c;
        }
    }
}

}  // namespace
}  // namespace kiln
