// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "server/compute/points.h"
#include "tests/kernels/chi_square.h"
#include "tests/kernels/one_lane.h"

// The directions that the kernels make of the host's own points, against the density by which each
// estimator divides: Pearson's test, with independent points (Sampler::random).
namespace {

using chi_square::Place;
using kiln::PointKind;

constexpr int kSamples = 1000000, kPolar = 80, kAzimuth = 160, kFine = 4;

/// A sampler's directions, and the density of its places on [0, 1] x [0, pi], both signs of y.
struct Subject {
    PointKind kind;
    std::function<Place(const double* point)> place;
    std::function<double(double t, double phi)> density;
};

/// One-sided probability of a statistic this large or larger.
double p_value(const Subject& subject) {
    const kiln::PointSet points =
        kiln::make_points(kiln::Sampler::random, subject.kind, 11, kSamples);
    std::vector<double> seen(kPolar * kAzimuth), expected(kPolar * kAzimuth);
    for (int i = 0; i < kSamples; ++i) {
        const Place at =
            subject.place(&points.values[kiln::point_scalars(subject.kind) * std::size_t(i)]);
        const int row = std::clamp(static_cast<int>(at.t * kPolar), 0, kPolar - 1);
        const int column =
            std::clamp(static_cast<int>(at.phi / std::numbers::pi * kAzimuth), 0, kAzimuth - 1);
        ++seen[static_cast<std::size_t>(row * kAzimuth + column)];
    }
    for (int cell = 0; cell < kPolar * kAzimuth; ++cell)
        for (int s = 0; s < kFine * kFine; ++s) {
            const double t = (cell / kAzimuth + (s / kFine + 0.5) / kFine) / kPolar;
            const double phi =
                std::numbers::pi * (cell % kAzimuth + (s % kFine + 0.5) / kFine) / kAzimuth;
            expected[static_cast<std::size_t>(cell)] += subject.density(t, phi) * std::numbers::pi *
                                                        kSamples /
                                                        (kPolar * kAzimuth * kFine * kFine);
        }
    double statistic = 0, pooled_seen = 0, pooled_expected = 0;
    int degrees = -1;
    for (std::size_t cell = 0; cell < seen.size(); ++cell) {
        pooled_seen += seen[cell];
        pooled_expected += expected[cell];
        if (pooled_expected < 10) continue;
        const double excess = pooled_seen - pooled_expected;
        statistic += excess * excess / pooled_expected;
        pooled_seen = pooled_expected = 0;
        ++degrees;
    }
    return chi_square::p_value(statistic, degrees);
}

Subject half_vectors(PointKind kind, double NoV, double alpha,
                     std::function<double(const textbook::Vector&)> density) {
    const auto place = [=](const double* point) {
        const in_double::View view = in_double::ggx_view(NoV, alpha);
        const in_double::HalfVector h =
            kind == PointKind::visible_normals ? in_double::ggx_sample_vndf(view, point)
            : kind == PointKind::ggx_normals   ? in_double::ggx_sample_ndf(view, point)
                                               : in_double::beckmann_sample_ndf(view, point);
        const double NoH = kind == PointKind::visible_normals ? KILN_VISIBLE_NOH : point[1];
        const double length = std::sqrt(h.hh), z = NoH / length;
        const double VoH = view.S * h.VoH2 / 2 / length;
        return chi_square::place_of_normal((VoH - NoV * z) / std::sqrt(1 - NoV * NoV), z, alpha);
    };
    const auto over_places = [=](double t, double phi) {
        const auto normal = chi_square::normal_at(t, phi, alpha);
        return normal.solid * density(normal.h);
    };
    return {kind, place, over_places};
}

/// Lights as scatter_hemisphere() takes them, t = 1 − NoL; its VoH serves for the azimuth.
Subject lights(PointKind kind, double NoV, std::function<double(double NoL)> density) {
    const auto place = [=](const double* point) {
        const int importance =
            kind == PointKind::uniform ? KILN_IMPORTANCE_UNIFORM : KILN_IMPORTANCE_COSINE;
        const in_double::Scattering s =
            in_double::scatter_hemisphere(importance, NoV, point[0], point[1], point[2]);
        const double VoL = 2 * s.VoH * s.VoH - 1;
        const double cos_phi = (VoL - NoV * s.NoL) / std::max(s.sinV * s.sinL, 1e-12);
        return Place{1 - s.NoL, std::acos(std::clamp(cos_phi, -1.0, 1.0))};
    };
    return {kind, place, [=](double t, double) { return 2 * density(1 - t); }};
}

double beckmann_normals(const textbook::Vector& h, double alpha) {
    const double c2 = h[2] * h[2], tan2 = (1 - c2) / c2;
    return std::exp(-tan2 / (alpha * alpha)) / (std::numbers::pi * alpha * alpha * c2 * c2) * h[2];
}

/// Density of v where tan θ = α sinh v is log-uniform: v = S u − ln(1 − u⁸) of an even u, S = 16.8
/// drawn out by `wrong`.
double log_tangents(double v, double wrong) {
    const double span = 16.8 * wrong;
    const auto of = [&](double u) { return span * u - std::log1p(-std::pow(u, 8)); };
    double low = 0, high = 1;
    for (int i = 0; i < 60; ++i) {
        const double middle = (low + high) / 2;
        (of(middle) < v ? low : high) = middle;
    }
    return 1 / (span + 8 * std::pow(low, 7) / (1 - std::pow(low, 8)));
}

/// v over [0, 40], beyond which one draw in 10^11 goes, as t. The third scalar of a point is the
/// density of all normals over its own, over NoH: 2 sinh v / cosh² v over p(v), over 1 / cosh v.
Subject log_tangent_normals(double wrong) {
    constexpr double kReach = 40;
    const auto place = [](const double* point) {
        const double v = std::acosh(1 / point[1]);
        EXPECT_NEAR(point[2] * log_tangents(v, 1) / (2 * std::tanh(v) / std::cosh(v)), 1, 1e-5);
        const double cos_phi = point[0] / std::tanh(v);
        return Place{v / kReach, std::acos(std::clamp(cos_phi, -1.0, 1.0))};
    };
    return {PointKind::log_tangents, place, [=](double t, double) {
                return kReach * log_tangents(kReach * t, wrong) / std::numbers::pi;
            }};
}

/// Horizon normals at one α, and as t the fourth root of the NoV that their points bring: the
/// chance of a tangent beyond their own, by the density of both halves, is even over the azimuths.
Subject horizon_normals(double alpha, double wrong) {
    const auto place = [=](const double* point) {
        const double NoV = point[5], tangent = std::tan(std::asin(NoV) / 2);
        const auto sample =
            in_double::sample_horizon_normal(in_double::ggx_view(NoV, alpha), point);
        const double t2 = sample.h.hh / (point[1] * point[1]) - 1;
        const double beta = std::hypot(tangent, alpha) * wrong;
        const double own = alpha * alpha / (alpha * alpha + t2),
                     wide = beta / std::sqrt(beta * beta + t2);
        return Place{std::pow(NoV, 0.25), (own + 3 * wide) / 4 * std::numbers::pi};
    };
    return {PointKind::horizon_normals, place, [](double, double) { return 1 / std::numbers::pi; }};
}

/// The light about a walk's facet, an even disc: √(1 − v sin² ψ) ∓ √v cos ψ, halved. t = 1 − √(1 −
/// v).
Subject facet_lights(double wrong) {
    const auto place = [](const double* point) {
        const double NoL = 2 * std::sqrt(point[1] * point[2]), x = point[2] - point[1];
        const double sine = std::sqrt((1 - NoL) * (1 + NoL));
        return Place{1 - NoL, std::acos(std::clamp(x / sine, -1.0, 1.0))};
    };
    const double power = 4 * (wrong - 1);
    return {PointKind::facet_walk, place, [=](double t, double) {
                return (2 + power) * std::pow(1 - t, 1 + power) / std::numbers::pi;
            }};
}

/// Every sampler with its density, the widths of the normals' drawn out by `wrong`, and the powers
/// of the lights' cosine raised by four times the excess.
std::vector<Subject> subjects(double wrong) {
    std::vector<Subject> all;
    for (const double NoV : {0.15, 0.5, 0.9})
        for (const double alpha : {0.1, 0.5, 1.0}) {
            const double a = alpha * wrong;
            all.push_back(half_vectors(PointKind::visible_normals, NoV, alpha, [=](const auto& h) {
                return textbook::visible_normals(h, NoV, a);
            }));
            all.push_back(half_vectors(PointKind::ggx_normals, NoV, alpha,
                                       [=](const auto& h) { return textbook::all_normals(h, a); }));
            all.push_back(half_vectors(PointKind::beckmann_normals, NoV, alpha,
                                       [=](const auto& h) { return beckmann_normals(h, a); }));
        }
    const double power = 4 * (wrong - 1), turn = 2 * std::numbers::pi;
    for (const double NoV : {0.15, 0.5, 0.9}) {
        for (const PointKind kind : {PointKind::cosine, PointKind::cosine_diffuse})
            all.push_back(lights(kind, NoV, [=](double NoL) {
                return (2 + power) / turn * std::pow(NoL, 1 + power);
            }));
        all.push_back(lights(PointKind::uniform, NoV, [=](double NoL) {
            return (1 + power) / turn * std::pow(NoL, power);
        }));
    }
    all.push_back(log_tangent_normals(wrong));
    for (const double alpha : {0.001, 0.1}) all.push_back(horizon_normals(alpha, wrong));
    all.push_back(facet_lights(wrong));
    return all;
}

// Level .01 over all subjects together: each at .01 over their number (Bonferroni).
TEST(Samplers, FollowTheDensityTheyAreDividedBy) {
    const std::vector<Subject> all = subjects(1);
    for (std::size_t i = 0; i < all.size(); ++i)
        EXPECT_GT(p_value(all[i]), 0.01 / static_cast<double>(all.size())) << "subject " << i;
}

// A width wrong by a twentieth, or a power by a fifth, is found at every subject.
TEST(Samplers, AWrongDensityIsRejected) {
    const std::vector<Subject> all = subjects(1.05);
    for (std::size_t i = 0; i < all.size(); ++i)
        EXPECT_LT(p_value(all[i]), 1e-4) << "subject " << i;
}

}  // namespace
