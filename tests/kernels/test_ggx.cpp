// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <functional>
#include <random>
#include <vector>

#include "server/compute/points.h"
#include "tests/kernels/one_lane.h"
#include "tests/kernels/textbook.h"

namespace {

using in_double::HalfVector;
using in_double::View;

struct Uniforms {
    std::mt19937_64 engine{42};
    double operator()() { return std::uniform_real_distribution<double>(1e-12, 1 - 1e-12)(engine); }
};

struct Sample {
    HalfVector h;
    double NoH;
};

Sample sample(bool visible, const View& view, double u, double phi) {
    const double rest = 1 - u, z = std::sqrt(rest);
    if (visible) {
        const auto point = kiln::visible_normal_point(std::cos(phi), u);
        return {in_double::ggx_sample_vndf(view, point.data()), KILN_VISIBLE_NOH};
    }
    const double point[] = {std::sqrt(u) * std::cos(phi), z, 1 / z, rest};
    return {in_double::ggx_sample_ndf(view, point), z};
}

/// The unit half vector, its y up to sign, from what the sampler keeps: N·h, V·h and h·h.
textbook::Vector unit_half_vector(const Sample& sample, const View& view, double NoV) {
    const auto& [h, NoH] = sample;
    const double length = std::sqrt(h.hh), z = NoH / length, VoH = view.S * h.VoH2 / 2 / length;
    const double x = (VoH - NoV * z) / std::sqrt(1 - NoV * NoV);
    return {x, std::sqrt(std::max(0.0, 1 - x * x - z * z)), z};
}

/// Pearson's statistic of 10^5 samples over 40 × 20 cells of (θ, φ), against the integral of
/// `density` over each cell (8 × 8 midpoints); thin cells are pooled. Returns the one-sided
/// probability of a larger one.
double chi_square_p(bool visible, double NoV, double alpha,
                    const std::function<double(const textbook::Vector&)>& density) {
    constexpr int kTheta = 40, kPhi = 20, kSamples = 100000, kSub = 8;
    const View view = in_double::ggx_view(NoV, alpha);
    // Cells even in atan(tanθ / α), so that they are filled at every width.
    const auto theta_of = [&](double t) {
        return std::atan(alpha * std::tan(t * std::numbers::pi / 2));
    };
    std::vector<double> seen(kTheta * kPhi), expected(kTheta * kPhi);
    Uniforms uniform;
    for (int i = 0; i < kSamples; ++i) {
        const double u = uniform(), phi = 2 * std::numbers::pi * uniform();
        const auto h = unit_half_vector(sample(visible, view, u, phi), view, NoV);
        const double t =
            std::atan(std::sqrt(1 - h[2] * h[2]) / h[2] / alpha) * 2 / std::numbers::pi;
        const double azimuth = std::atan2(h[1], h[0]) / std::numbers::pi;
        const int row = std::min(kTheta - 1, static_cast<int>(t * kTheta));
        const int column = std::min(kPhi - 1, static_cast<int>(azimuth * kPhi));
        ++seen[static_cast<std::size_t>(row * kPhi + column)];
    }
    for (int cell = 0; cell < kTheta * kPhi; ++cell) {
        for (int s = 0; s < kSub * kSub; ++s) {
            const double t = (cell / kPhi + (s / kSub + 0.5) / kSub) / kTheta, dt = 1e-6;
            const double theta = theta_of(t),
                         slope = (theta_of(t + dt) - theta_of(t - dt)) / (2 * dt);
            const double phi = std::numbers::pi * (cell % kPhi + (s % kSub + 0.5) / kSub) / kPhi;
            const textbook::Vector h = {std::sin(theta) * std::cos(phi),
                                        std::sin(theta) * std::sin(phi), std::cos(theta)};
            // Both signs of y fall into the cell.
            expected[static_cast<std::size_t>(cell)] += 2 * density(h) * std::sin(theta) * slope /
                                                        kTheta * std::numbers::pi / kPhi /
                                                        (kSub * kSub) * kSamples;
        }
    }
    double statistic = 0, pooled_seen = 0, pooled_expected = 0;
    int degrees = -1;
    for (std::size_t cell = 0; cell < seen.size(); ++cell) {
        pooled_seen += seen[cell];
        pooled_expected += expected[cell];
        if (pooled_expected < 5) continue;
        statistic +=
            (pooled_seen - pooled_expected) * (pooled_seen - pooled_expected) / pooled_expected;
        pooled_seen = pooled_expected = 0;
        ++degrees;
    }
    // Wilson, Hilferty 1931: the cube root is nearly normal; good to 1e-3 for hundreds of degrees.
    const double k = degrees,
                 z = (std::cbrt(statistic / k) - (1 - 2 / (9 * k))) / std::sqrt(2 / (9 * k));
    return 0.5 * std::erfc(z / std::sqrt(2.0));
}

struct Case {
    double NoV, alpha;
};
const std::vector<Case> kCases = {{0.05, 0.05}, {0.3, 0.05}, {0.9, 0.05}, {0.05, 0.25}, {0.3, 0.25},
                                  {0.9, 0.25},  {0.05, 1},   {0.3, 1},    {0.9, 1},     {0.6, 0.6}};
// Level .01 over 10 cases × 2 samplers, Šidák: 1 − .99^(1/20).
constexpr double kLevel = 5e-4;

}  // namespace

TEST(Ggx, VisibleNormalsFollowTheirDensity) {
    for (const auto& [NoV, alpha] : kCases)
        EXPECT_GT(
            chi_square_p(true, NoV, alpha,
                         [&](const auto& h) { return textbook::visible_normals(h, NoV, alpha); }),
            kLevel)
            << NoV << " " << alpha;
}

TEST(Ggx, AllNormalsFollowTheirDensity) {
    for (const auto& [NoV, alpha] : kCases)
        EXPECT_GT(chi_square_p(false, NoV, alpha,
                               [&](const auto& h) { return textbook::all_normals(h, alpha); }),
                  kLevel)
            << NoV << " " << alpha;
}

TEST(Ggx, AWrongDensityIsRejected) {
    for (const auto& [NoV, alpha] : kCases) {
        EXPECT_LT(chi_square_p(true, NoV, alpha,
                               [&](const auto& h) {
                                   return textbook::visible_normals(h, NoV, alpha * 1.05);
                               }),
                  1e-6);
        EXPECT_LT(
            chi_square_p(false, NoV, alpha,
                         [&](const auto& h) { return textbook::all_normals(h, alpha * 1.05); }),
            1e-6);
    }
}

TEST(Ggx, TheMirroredLightIsTheReflectedVector) {
    Uniforms uniform;
    for (int i = 0; i < 10000; ++i) {
        const double NoV = 0.02 + 0.97 * uniform(), alpha = 0.02 + 0.98 * uniform();
        const View view = in_double::ggx_view(NoV, alpha);
        for (const bool visible : {true, false}) {
            const Sample drawn = sample(visible, view, uniform(), 6.28 * uniform());
            const HalfVector& h = drawn.h;
            const textbook::Vector unit = unit_half_vector(drawn, view, NoV);
            const double VoH = textbook::dot(textbook::view(NoV), unit);
            const double NoL = 2 * VoH * unit[2] - NoV, scale = 16777216 * h.hh / view.S;
            const in_double::Light light = in_double::ggx_mirror(view, h, drawn.NoH);
            // Differences of numbers near 1, some ten roundings, scaled back.
            EXPECT_NEAR(light.NoL / scale, NoL, 1e-12);
            EXPECT_NEAR(light.S / scale, std::sqrt(NoL * NoL + alpha * alpha * (1 - NoL * NoL)),
                        1e-12);
            EXPECT_NEAR(in_double::ggx_excess(view, h, light) / (scale * scale),
                        alpha * alpha * (1 - NoL * NoL), 1e-12);
            EXPECT_NEAR(in_double::ggx_VoH(view, h), VoH, 1e-12);
            EXPECT_NEAR(in_double::ggx_one_minus_VoH(view, h), 1 - VoH, 1e-12);
        }
    }
}

TEST(Ggx, TheRatioOfDensitiesIsTheirQuotient) {
    Uniforms uniform;
    for (int i = 0; i < 10000; ++i) {
        const double NoV = 0.02 + 0.97 * uniform(), alpha = 0.02 + 0.98 * uniform(),
                     u = 0.99 * uniform();
        const View view = in_double::ggx_view(NoV, alpha);
        const Sample drawn = sample(false, view, u, 6.28 * uniform());
        const textbook::Vector unit = unit_half_vector(drawn, view, NoV);
        const double wanted =
            textbook::visible_normals(unit, NoV, alpha) / textbook::all_normals(unit, alpha);
        EXPECT_NEAR(in_double::ggx_vndf_over_ndf(view, drawn.h, 1 / std::sqrt(1 - u)), wanted,
                    1e-9 * (1 + wanted));
    }
}
