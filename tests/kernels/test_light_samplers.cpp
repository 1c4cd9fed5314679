// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <utility>
#include <vector>

#include "server/compute/points.h"
#include "tests/kernels/chi_square.h"
#include "tests/kernels/drawn_lights.h"

// The samplers of jobs of 4096 samples and more. A light of theirs has a weight, by which it stands
// for so many visible normals, or so much of a diffuse lobe: weights summed over cells against the
// integral of what they stand for, by Pearson's test of independent points (Sampler::random).
namespace {

using chi_square::Place;
using drawn_lights::Setting;
using kiln::PointKind;
using textbook::Vector;

constexpr int kSamples = 1000000, kPolar = 20, kAzimuth = 40, kFine = 16;
/// Lights of equal weight that would tell as much as those of a cell, or of some that are taken
/// together, from which on the variance of their weights is known: it biases the statistic by some
/// 2 / 300.
constexpr double kLightsMin = 300;

struct WeightedPlace {
    Place at;
    double weight;
};

/// What stands for how much, dt dphi, on [0, 1] x [0, pi].
using Density = std::function<double(double t, double phi)>;

struct Cell {
    double weights = 0, squares = 0, expected = 0;
    void add(const Cell& other) {
        weights += other.weights, squares += other.squares, expected += other.expected;
    }
    bool known() const { return weights * weights >= kLightsMin * squares && squares > 0; }
};

class Histogram {
  public:
    Histogram(PointKind kind, const std::function<WeightedPlace(const double* point)>& draw)
        : cells_(kPolar * kAzimuth) {
        const auto& points = points_of(kind);
        for (std::size_t i = 0; i < kSamples; ++i) {
            const WeightedPlace light = draw(&points[kiln::kPointScalars * i]);
            if (!(light.weight > 0)) continue;
            const int row = std::clamp(static_cast<int>(light.at.t * kPolar), 0, kPolar - 1);
            const int column = std::clamp(
                static_cast<int>(light.at.phi / std::numbers::pi * kAzimuth), 0, kAzimuth - 1);
            cells_[static_cast<std::size_t>(row * kAzimuth + column)].add(
                {light.weight, light.weight * light.weight, 0});
        }
    }

    /// One-sided probability of sums as far from the density's as these, or farther. Their total is
    /// not given, so cells are as many as degrees of freedom. Those that an edge crosses, of which
    /// midpoints know little and weights at the horizon, 0 there, much, are one cell together.
    double p_value(const Density& density) const {
        double statistic = 0;
        int degrees = 0;
        Cell pooled, edges;
        const auto judge = [&](const Cell& cell) {
            const double excess = cell.weights - cell.expected;
            statistic += excess * excess / cell.squares;
            ++degrees;
        };
        for (std::size_t i = 0; i < cells_.size(); ++i) {
            Cell cell = cells_[i];
            const bool whole = add_expected(static_cast<int>(i), density, &cell);
            (whole ? pooled : edges).add(cell);
            if (!pooled.known()) continue;
            judge(pooled);
            pooled = {};
        }
        if (edges.known()) judge(edges);
        EXPECT_GT(degrees, 20);
        return chi_square::p_value(statistic, degrees);
    }

  private:
    static const std::vector<double>& points_of(PointKind kind) {
        static std::map<PointKind, std::vector<double>> made;
        auto& points = made[kind];
        if (points.empty())
            points = kiln::make_points(kiln::Sampler::random, kind, 11, kSamples).values;
        return points;
    }
    /// Whether all of it counts.
    static bool add_expected(int cell, const Density& density, Cell* sums) {
        double sum = 0;
        bool whole = true;
        for (int s = 0; s < kFine * kFine; ++s) {
            const double t = (cell / kAzimuth + (s / kFine + 0.5) / kFine) / kPolar;
            const double phi =
                std::numbers::pi * (cell % kAzimuth + (s % kFine + 0.5) / kFine) / kAzimuth;
            const double one = density(t, phi);
            sum += one, whole &= one > 0;
        }
        sums->expected = sum * std::numbers::pi * kSamples / (kPolar * kAzimuth * kFine * kFine);
        return whole;
    }
    std::vector<Cell> cells_;
};

/// Level .01 over all that is tested here together, each at .01 over their number (Bonferroni).
constexpr double kLevel = 0.01 / 25;

void expect_follows(const Histogram& seen, const Density& density, const Density& wrong) {
    EXPECT_GT(seen.p_value(density), kLevel);
    EXPECT_LT(seen.p_value(wrong), 1e-4);
}

/// Visible normals of a width, of those that `counts` says.
Density normals(const Setting& at, double width, std::function<bool(const Vector& h)> counts) {
    return [=](double t, double phi) {
        const auto normal = chi_square::normal_at(t, phi, at.alpha);
        return counts(normal.h) ? normal.solid * textbook::visible_normals(normal.h, at.NoV, width)
                                : 0;
    };
}

WeightedPlace placed(const Setting& at, const in_double::VisibleLight& light) {
    const Vector h = drawn_lights::half_vector(at, light);
    return {chi_square::place_of_normal(h[0], h[2], at.alpha), light.weight};
}

void expect_normals(const Setting& at, const Histogram& seen,
                    const std::function<bool(const Vector& h)>& counts) {
    expect_follows(seen, normals(at, at.alpha, counts), normals(at, at.alpha * 1.05, counts));
}

// A width wrong by a twentieth is found.
TEST(LightSamplers, VisibleLightsAreTheVisibleNormalsThatMirrorAboveTheHorizon) {
    for (const double NoV : {0.15, 0.5, 0.9})
        for (const double alpha : {0.05, 0.35, 1.0}) {
            SCOPED_TRACE(testing::Message() << "NoV " << NoV << " alpha " << alpha);
            const Setting at{NoV, alpha};
            const auto view = in_double::ggx_view(NoV, alpha);
            const Histogram seen(PointKind::visible_lights, [&](const double* point) {
                return placed(at, in_double::sample_visible_light(view, point));
            });
            expect_normals(at, seen, [=](const Vector& h) {
                return drawn_lights::light_elevation(at, h) > 0;
            });
        }
}

in_double::Rim rim_of(double ior) {
    const double p[] = {(ior - 1) * (ior + 1), ior * ior};
    return in_double::total_reflection_rim(p);
}

// Where the stretched view itself, the middle of the lobe, is beyond the rim, all lights are among
// the reflected ones.
TEST(LightSamplers, PartedLightsAreThoseOnEitherSideOfTheRim) {
    const std::pair<Setting, double> cases[] = {{{0.3, 0.3}, 1 / 1.5},
                                                {{0.3, 0.3}, 0.9},
                                                {{0.3, 1}, 0.9},
                                                {{0.74, 0.1}, 1 / 1.5},
                                                {{0.9, 1}, 1 / 1.5}};
    for (const auto& [at, ior] : cases)
        for (const bool transmitted : {true, false}) {
            SCOPED_TRACE(testing::Message()
                         << "NoV " << at.NoV << " alpha " << at.alpha << " ior " << ior
                         << (transmitted ? " transmitted" : " reflected"));
            const auto view = in_double::ggx_view(at.NoV, at.alpha);
            const auto rim = rim_of(ior);
            const Histogram seen(PointKind::parted_lights, [&](const double* point) {
                const auto lights = in_double::sample_parted_lights(view, rim, point);
                return placed(at, transmitted ? lights.transmitted : lights.reflected);
            });
            const Vector V = textbook::view(at.NoV);
            const Vector middle = textbook::normalized({at.alpha * at.alpha * V[0], 0, V[2]});
            const double most = textbook::dot(V, middle);
            const bool all = !transmitted && most * most < rim.cos2;
            expect_normals(at, seen, [=](const Vector& h) {
                const double VoH = textbook::dot(V, h);
                return drawn_lights::light_elevation(at, h) > 0 &&
                       (all || (VoH * VoH > rim.cos2) == transmitted);
            });
        }
}

// A power of the cosine wrong by a fifth is found. Lights by t = 1 − NoL.
TEST(LightSamplers, TransmittedLightsAreThoseOfACosineLobe) {
    for (const double NoV : {0.15, 0.5, 0.9})
        for (const double ior : {1 / 1.5, 0.9}) {
            SCOPED_TRACE(testing::Message() << "NoV " << NoV << " ior " << ior);
            const auto rim = rim_of(ior);
            const Histogram seen(PointKind::parted_lights_diffuse, [&](const double* point) {
                const auto light = in_double::sample_transmitted_light(NoV, rim, point);
                return WeightedPlace{{1 - light.d.NoL, std::acos(light.d.cos_phi)}, light.weight};
            });
            const auto lobe = [=](double power) {
                return [=](double t, double phi) {
                    const double NoL = 1 - t, sine = std::sqrt(t * (2 - t));
                    const Vector L = {sine * std::cos(phi), sine * std::sin(phi), NoL};
                    const bool is_transmitted =
                        (1 + textbook::dot(textbook::view(NoV), L)) / 2 > rim.cos2;
                    return is_transmitted ? (1 + power) * std::pow(NoL, power) / std::numbers::pi
                                          : 0;
                };
            };
            expect_follows(seen, lobe(1), lobe(1.2));
        }
}

}  // namespace
