// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "server/compute/points.h"
#include "tests/kernels/drawn_lights.h"

// Lights parted where total reflection begins: their densities and their sides.
namespace {

using drawn_lights::light_elevation;
using drawn_lights::normals_at;
using drawn_lights::Setting;
using textbook::Vector;

// Views within and beyond the rim of each ior, and lobes that it crosses.
constexpr Setting kSettings[] = {{0.02, 0.035}, {0.3, 1e-3}, {0.3, 0.3},  {0.5, 0.35},
                                 {0.7, 0.05},   {0.74, 0.1}, {0.75, 0.1}, {0.9, 0.01},
                                 {0.9, 1},      {0.99, 0.3}, {0.01, 1}};
constexpr double kIors[] = {0.1, 1 / 1.5, 0.9, 0.9999};

std::array<double, 6> point_at(double phi, double t) {
    const double rest = 1 - t;
    return {std::cos(phi), t * t * (1 + 2 * rest), 6 * t * rest, rest * rest * (1 + 2 * t), 0, 0};
}

in_double::Rim rim_of(double ior) {
    const double p[] = {(ior - 1) * (ior + 1), ior * ior};
    return in_double::total_reflection_rim(p);
}

in_double::PartedLights draw(const Setting& at, double ior, double phi, double t) {
    return in_double::sample_parted_lights(in_double::ggx_view(at.NoV, at.alpha), rim_of(ior),
                                           point_at(phi, t).data());
}

double VoH(const Setting& at, const Vector& h) { return textbook::dot(textbook::view(at.NoV), h); }

TEST(PartedLights, WeighAsManyVisibleNormalsAsTheyStandFor) {
    int held[2] = {0, 0};
    for (const Setting& at : kSettings)
        for (const double ior : kIors)
            for (const double phi : {0.2, 0.9, 1.6, 2.4, 3.0})
                for (const double t : {0.1, 0.4, 0.7, 0.95})
                    for (const bool transmitted : {true, false}) {
                        const auto sample = [&](double by_phi, double by_t) {
                            const auto lights = draw(at, ior, phi + by_phi, t + by_t);
                            return transmitted ? lights.transmitted : lights.reflected;
                        };
                        // Where two sides meet in one azimuth a difference is none.
                        const double weight = sample(0, 0).weight;
                        if (weight < 1e-3) continue;
                        const double normals = normals_at(at, sample, 3e-4);
                        EXPECT_NEAR(weight / normals, 1, 1e-4)
                            << at.NoV << " " << at.alpha << " ior " << ior << " " << phi << " " << t
                            << (transmitted ? " transmitted" : " reflected");
                        ++held[transmitted];
                    }
    EXPECT_GT(held[0], 300);
    EXPECT_GT(held[1], 300);
}

// Every light is above the horizon and on its side of the rim; each span ends on one of the two.
TEST(PartedLights, EndAtTheRimAndAtTheHorizon) {
    for (const Setting& at : kSettings)
        for (const double ior : kIors) {
            const double rim = std::sqrt(rim_of(ior).cos2);
            for (double phi = 0.01; phi < 3.14; phi += 0.05) {
                for (const double t : {0.01, 0.5, 0.9, 0.99}) {
                    const auto lights = draw(at, ior, phi, t);
                    const Vector h = drawn_lights::half_vector(at, lights.transmitted);
                    const Vector rest = drawn_lights::half_vector(at, lights.reflected);
                    if (lights.transmitted.weight > 0) {
                        EXPECT_GT(VoH(at, h), rim - 1e-9);
                        EXPECT_GT(light_elevation(at, h), -1e-9);
                    }
                    if (lights.reflected.weight > 0) {
                        EXPECT_GT(light_elevation(at, rest), -1e-9);
                        if (lights.too_much == 0) {
                            EXPECT_LT(VoH(at, rest), rim + 1e-9);
                        }
                    }
                }
                const auto ends = draw(at, ior, phi, 1), begins = draw(at, ior, phi, 0);
                const auto middle = draw(at, ior, phi, .5);
                if (middle.transmitted.weight > 1e-9) {
                    const Vector end = drawn_lights::half_vector(at, ends.transmitted);
                    const Vector begin = drawn_lights::half_vector(at, begins.transmitted);
                    EXPECT_NEAR(std::min(VoH(at, end) - rim, light_elevation(at, end)), 0, 1e-8)
                        << at.NoV << " " << at.alpha << " ior " << ior << " " << phi;
                    if (ends.too_much == 1) {
                        EXPECT_NEAR(VoH(at, begin), rim, 1e-8);
                    }
                }
                if (middle.reflected.weight > 1e-9) {
                    const Vector end = drawn_lights::half_vector(at, ends.reflected);
                    EXPECT_NEAR(light_elevation(at, end), 0, 1e-8);
                }
            }
        }
}

// Both kinds of the host's points: the spans' shares of the visible normals, and of a lobe of 1 the
// cosine-weighted share of the lights that are transmitted. Counting knows them to 4096^-3/4 in
// each of 16 sets: two deviations of all are 1e-3.
TEST(PartedLights, HostsPointsHaveTheShareOfEachSide) {
    constexpr int kSamples = 1 << 16;
    const auto make = [](kiln::PointKind kind) {
        return kiln::make_points(kiln::Sampler::sobol_owen, kind, 3, kSamples).values;
    };
    const auto points = make(kiln::PointKind::parted_lights);
    const auto of_diffuse = make(kiln::PointKind::parted_lights_diffuse);
    const auto normals = make(kiln::PointKind::visible_normals);
    const auto cosines = make(kiln::PointKind::cosine_diffuse);
    for (const Setting& at : {Setting{0.3, 0.3}, {0.74, 0.1}, {0.9, 1}})
        for (const double ior : kIors) {
            const auto rim = rim_of(ior);
            const auto view = in_double::ggx_view(at.NoV, at.alpha);
            double share = 0, above = 0, lit = 0, counted = 0;
            for (std::size_t i = 0; i < kSamples; ++i) {
                const double one = 1. / kSamples, *normal = &normals[6 * i],
                             *cosine = &cosines[6 * i];
                const auto lights = in_double::sample_parted_lights(view, rim, &points[6 * i]);
                share += lights.transmitted.weight * one;
                const auto h = in_double::ggx_sample_vndf(view, normal);
                const double c = in_double::ggx_VoH(view, h);
                const bool up = in_double::ggx_mirror(view, h, KILN_VISIBLE_NOH).NoL > 0;
                above += up && c * c > rim.cos2 ? one : 0;
                lit += in_double::sample_transmitted_light(at.NoV, rim, &of_diffuse[6 * i]).weight *
                       one;
                const auto d =
                    in_double::diffuse_directions(at.NoV, cosine[1], cosine[2], cosine[0]);
                counted += d.VoH * d.VoH > rim.cos2 ? one : 0;
            }
            EXPECT_NEAR(share, above, 1e-3) << at.NoV << " " << at.alpha << " ior " << ior;
            EXPECT_NEAR(lit, counted, 1e-3) << at.NoV << " ior " << ior;
        }
}

TEST(PartedLights, OfADiffuseLobeAreTransmittedAndWeighTheirSolidAngle) {
    for (const double NoV : {0.01, 0.3, 0.75, 0.99, 1.0})
        for (const double ior : kIors)
            for (const double psi : {0.2, 0.9, 1.6, 2.4, 3.0})
                for (const double t : {0.1, 0.4, 0.7, 0.95}) {
                    const auto rim = rim_of(ior);
                    const auto sample = [&](double by_psi, double by_t) {
                        return in_double::sample_transmitted_light(
                            NoV, rim, point_at(psi + by_psi, t + by_t).data());
                    };
                    const auto direction = [&](double by_psi, double by_t) {
                        const auto d = sample(by_psi, by_t).d;
                        const double side = std::sqrt((1 - d.cos_phi) * (1 + d.cos_phi));
                        return Vector{d.sinL * d.cos_phi, d.sinL * side, d.NoL};
                    };
                    const auto made = sample(0, 0);
                    const auto& d = made.d;
                    const Vector L = direction(0, 0), V = textbook::view(NoV);
                    const Vector H = textbook::normalized({L[0] + V[0], L[1] + V[1], L[2] + V[2]});
                    EXPECT_NEAR(textbook::dot(L, L), 1, 1e-9);
                    EXPECT_NEAR(textbook::dot(V, H), d.VoH, 1e-9);
                    EXPECT_NEAR(H[2], d.NoH, 1e-9);
                    EXPECT_GE(d.VoH * d.VoH, rim.cos2 - 1e-12);
                    // Where the azimuth about the normal is 0 or π the sine above has no digits.
                    if (d.sinL * (1 - std::abs(d.cos_phi)) < 1e-4 || made.weight < 1e-6) continue;
                    const double area = drawn_lights::area_at(direction, 3e-4);
                    EXPECT_NEAR(made.weight / (2 * d.NoL * area), 1, 1e-4)
                        << NoV << " ior " << ior << " " << psi << " " << t;
                }
}

TEST(PartedLights, AreNumbersInFloat) {
    for (const float NoV : {0.0f, 1e-6f, 0.7f, 1.0f})
        for (const float ior : {1e-4f, 0.7f, 0.9999999f}) {
            const float p[] = {(ior - 1) * (ior + 1), ior * ior};
            const auto rim = in_float::total_reflection_rim(p);
            for (const float phi : {0.01f, 1.5f, 3.1f})
                for (const float t : {1e-5f, 0.5f, 0.99999f}) {
                    const auto wide = point_at(phi, t);
                    float point[6];
                    std::copy(wide.begin(), wide.end(), point);
                    const auto light = in_float::sample_transmitted_light(NoV, rim, point);
                    EXPECT_TRUE(std::isfinite(light.weight) && light.weight >= 0 &&
                                std::isfinite(light.d.cos_phi) && light.d.VoH > 0)
                        << NoV << " " << ior << " " << phi << " " << t;
                    for (const float alpha : {0.0f, 1e-4f, 1.0f}) {
                        const auto lights = in_float::sample_parted_lights(
                            in_float::ggx_view(NoV, alpha), rim, point);
                        for (const auto& one : {lights.transmitted, lights.reflected})
                            EXPECT_TRUE(std::isfinite(one.weight) && one.weight >= 0 &&
                                        one.h.VoH2 >= 0 && one.h.hh > 0)
                                << NoV << " " << alpha << " " << ior << " " << phi << " " << t;
                    }
                }
        }
}

}  // namespace
