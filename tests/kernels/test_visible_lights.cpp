// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "server/compute/points.h"
#include "tests/kernels/drawn_lights.h"

// Visible normals whose lights are above the horizon: their density and their edge.
namespace {

using drawn_lights::light_elevation;
using drawn_lights::normals_at;
using drawn_lights::Setting;
using textbook::Vector;

constexpr Setting kSettings[] = {{0.01, 0.01}, {0.02, 0.035}, {0.3, 1e-3}, {0.3, 0.1},
                                 {0.5, 0.35},  {0.9, 0.01},   {0.9, 1},    {0.99, 0.3}};

in_double::VisibleLight draw(const Setting& at, double phi, double t) {
    const double rest = 1 - t, u = t * (2 - t);
    const double point[] = {std::cos(phi), std::sqrt(u), 2 * rest, u, rest * rest, 0};
    return in_double::sample_visible_light(in_double::ggx_view(at.NoV, at.alpha), point);
}

Vector half_vector(const Setting& at, double phi, double t) {
    return drawn_lights::half_vector(at, draw(at, phi, t));
}

// What a point stands for is its weight's part of the visible normals.
TEST(VisibleLights, WeighAsManyVisibleNormalsAsTheyStandFor) {
    for (const Setting& at : kSettings)
        for (const double phi : {0.2, 0.9, 1.6, 2.4, 3.0})
            for (const double t : {0.1, 0.4, 0.7, 0.95}) {
                const auto sample = [&](double by_phi, double by_t) {
                    return draw(at, phi + by_phi, t + by_t);
                };
                EXPECT_NEAR(draw(at, phi, t).weight / normals_at(at, sample, 1e-3), 1, 2e-5)
                    << at.NoV << " " << at.alpha << " " << phi << " " << t;
            }
}

TEST(VisibleLights, EndAtTheHorizonAndNotBefore) {
    for (const Setting& at : kSettings)
        for (double phi = 0.01; phi < 3.14; phi += 0.05) {
            EXPECT_NEAR(light_elevation(at, half_vector(at, phi, 1)), 0, 1e-9)
                << at.NoV << " " << at.alpha << " " << phi;
            for (const double t : {0.01, 0.5, 0.9, 0.999})
                EXPECT_GT(light_elevation(at, half_vector(at, phi, t)), 0)
                    << at.NoV << " " << at.alpha << " " << phi << " " << t;
        }
}

// The host's points are those that the kernel asks for: a mean of weights is the visible normals'
// share above the horizon, which a lattice of ggx_sample_vndf() counts to its N^-3/4.
TEST(VisibleLights, HostsPointsHaveTheShareAboveTheHorizon) {
    constexpr int kSamples = 1 << 18;
    const auto points =
        kiln::make_points(kiln::Sampler::sobol_owen, kiln::PointKind::visible_lights, 3, kSamples);
    const auto normals =
        kiln::make_points(kiln::Sampler::sobol_owen, kiln::PointKind::visible_normals, 3, kSamples);
    for (const Setting& at : {Setting{0.3, 0.1}, {0.5, 0.35}, {0.9, 1}}) {
        const auto view = in_double::ggx_view(at.NoV, at.alpha);
        double share = 0, above = 0;
        for (std::size_t i = 0; i < kSamples; ++i) {
            share += in_double::sample_visible_light(view, &points.values[6 * i]).weight / kSamples;
            const double* normal = &normals.values[6 * i];
            const auto h = in_double::ggx_sample_vndf(view, normal);
            above += in_double::ggx_mirror(view, h, KILN_VISIBLE_NOH).NoL > 0 ? 1. / kSamples : 0;
        }
        EXPECT_NEAR(share, above, 5e-5) << at.NoV << " " << at.alpha;
    }
}

// Where float has no digits left of the quadratic, nothing of the lobe is below the horizon.
TEST(VisibleLights, HaveLimitsInFloat) {
    const float point[] = {0.6f, 0.8f, 1.2f, 0.64f, 0.36f, 0};
    for (const float NoV : {0.0f, 1e-6f, 0.5f, 1.0f})
        for (const float alpha : {1e-8f, 1e-6f, 0.35f}) {
            const auto sample =
                in_float::sample_visible_light(in_float::ggx_view(NoV, alpha), point);
            EXPECT_TRUE(std::isfinite(sample.weight) && std::isfinite(sample.h.VoH2) &&
                        sample.h.hh > 0)
                << NoV << " " << alpha;
            if (NoV >= 0.5f && alpha <= 1e-6f) {
                EXPECT_NEAR(sample.weight, 1.2f, 2e-6f) << NoV << " " << alpha;
            }
        }
}

}  // namespace
