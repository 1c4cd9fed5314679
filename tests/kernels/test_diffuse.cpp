// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

#include "tests/kernels/one_lane.h"
#include "tests/kernels/textbook.h"

namespace {

using in_double::diffuse_directions;
using in_double::diffuse_lobe;
using in_double::Directions;
using std::numbers::pi;

/// Every lobe that there is; a walk has no value at a pair of directions.
std::vector<int> lobes() {
    std::vector<int> all;
#define KILN_TEST_ROW(number, word) all.push_back(KILN_DIFFUSE_##number);
    KILN_DIFFUSE_ROWS(KILN_TEST_ROW)
    std::erase(all, KILN_DIFFUSE_GGX_LAMBERT);
    return all;
}
const std::vector<int> kModels = lobes();

struct Node {
    double x, weight;
};

/// Gauss-Legendre on [0, 1]: the zeros of P_n by Newton's method.
std::vector<Node> gauss(int n) {
    std::vector<Node> nodes;
    for (int i = 0; i < n; ++i) {
        double x = std::cos(pi * (i + 0.75) / (n + 0.5)), slope = 1;
        for (int step = 0; step < 50; ++step) {
            double before = 1, p = x;
            for (int k = 2; k <= n; ++k)
                before = std::exchange(p, ((2 * k - 1) * x * p - (k - 1) * before) / k);
            slope = n * (x * p - before) / (x * x - 1);
            x -= p / slope;
        }
        nodes.push_back({(1 + x) / 2, 1 / ((1 - x * x) * slope * slope)});
    }
    return nodes;
}

/// `nodes` on every one of `pieces` equal parts of [ends[0], ends[1]] and of [ends[1], ends[2]].
std::vector<Node> panels(const std::array<double, 3>& ends, int pieces,
                         const std::vector<Node>& nodes) {
    std::vector<Node> out;
    for (std::size_t side = 0; side < 2; ++side)
        for (int piece = 0; piece < pieces; ++piece)
            for (const Node& node : nodes) {
                const double width = ends[side + 1] - ends[side];
                out.push_back(
                    {ends[side] + width * (piece + node.x) / pieces, width * node.weight / pieces});
            }
    return out;
}

/// ∫ f NoL dω, in panels between the models' kinks at NoL = NoV and φ = π/2. The upper bound of
/// Chan 2018 is a kink along a curve: many short panels follow it.
double albedo(int model, double NoV, double roughness, double rho) {
    const int pieces = model == KILN_DIFFUSE_CHAN2018 ? 12 : 1;
    static const std::vector<Node> nodes = gauss(96), few = gauss(24);
    const std::vector<Node>& used = pieces > 1 ? few : nodes;
    const std::vector<Node> theta = panels({0, std::acos(NoV), pi / 2}, pieces, used);
    const std::vector<Node> phi = panels({0, pi / 2, pi}, pieces, used);
    double sum = 0;
    for (const Node& t : theta)
        for (const Node& p : phi) {
            const double NoL = std::cos(t.x), sinL = std::sin(t.x);
            const Directions d = diffuse_directions(NoV, NoL, sinL, std::cos(p.x));
            sum += t.weight * p.weight * NoL * sinL * diffuse_lobe(model, d, roughness, rho);
        }
    return 2 * sum / pi;
}

struct Anchor {
    int model;
    double NoV, roughness, rho, value, tolerance;
};

class DiffuseAnchor : public ::testing::TestWithParam<Anchor> {};

TEST_P(DiffuseAnchor, Agrees) {
    const Anchor a = GetParam();
    EXPECT_NEAR(albedo(a.model, a.NoV, a.roughness, a.rho), a.value, a.tolerance)
        << "model " << a.model << " NoV " << a.NoV << " roughness " << a.roughness << " albedo "
        << a.rho;
}

/// A row of white albedos at NoV = .05, .25, .5, .75 and 1 (.999 of Chan's), to six digits.
void add(std::vector<Anchor>& to, int model, double roughness, double rho,
         std::array<double, 5> values) {
    const bool chan = model == KILN_DIFFUSE_CHAN2018 || model == KILN_DIFFUSE_CHAN2024;
    const std::array<double, 5> NoV = {.05, .25, .5, .75, chan ? .999 : 1};
    for (std::size_t i = 0; i < 5; ++i)
        to.push_back({model, NoV[i], roughness, rho, values[i], 1.01e-6});
}

/// Values that two other integrators agree on; six digits are ±1 in the last.
std::vector<Anchor> anchors() {
    std::vector<Anchor> all;
    add(all, KILN_DIFFUSE_BURLEY, 0, 1, {.598512, .860363, .960938, .975714, .976190});
    add(all, KILN_DIFFUSE_BURLEY, .5, 1, {1.017407, 1.022492, 1.008320, 1.004711, 1.005952});
    add(all, KILN_DIFFUSE_BURLEY, 1, 1, {1.463614, 1.193435, 1.056904, 1.033747, 1.035714});
    add(all, KILN_DIFFUSE_OREN_NAYAR, .5, 1, {.944459, .919309, .883128, .844277, .784483});
    add(all, KILN_DIFFUSE_EON, 1, .8, {.797669, .787696, .775124, .764510, .758723});
    add(all, KILN_DIFFUSE_EON_UNREAL, 1, 1, {1.017546, 1.004249, .987054, .980462, 1});
    add(all, KILN_DIFFUSE_CHAN2024, .5, 1, {.989417, .959810, .955824, .963735, .976835});
    add(all, KILN_DIFFUSE_CHAN2024, 1, 1, {.993537, .947482, .941282, .953587, .973966});
    add(all, KILN_DIFFUSE_CHAN2018, 1, 1, {1.066229, .972182, .938888, .947570, .973097});
    const int oren_nayar = KILN_DIFFUSE_OREN_NAYAR, full = KILN_DIFFUSE_OREN_NAYAR_FULL;
    const std::vector<Anchor> exact = {
        {KILN_DIFFUSE_BURLEY, .1, 1, 1, 1.3801258410714285, 1e-12},
        {KILN_DIFFUSE_BURLEY, .5, .25, 1, 0.9844786628844246, 1e-12},
        {KILN_DIFFUSE_BURLEY, 1, 1, 1, 1.0357142857142858, 1e-12},
        {KILN_DIFFUSE_EON, .1, .5, .8, 0.7974975692390922, 1e-12},
        {KILN_DIFFUSE_EON, 1, .5, .8, 0.778234047052139, 1e-12},
        {KILN_DIFFUSE_EON, .5, 1, .5, 0.4632584949807224, 1e-12},
        {KILN_DIFFUSE_EON, .01, .25, .18, 0.17988893441269915, 1e-12},
        {oren_nayar, .1, 1, 1, 0.8163830098637354, 1e-12},
        {oren_nayar, .5, 1, 1, 0.7471409754343431, 1e-12},
        {full, .1, 1, 1, 0.8924512228256967, 1e-12},
        {full, .5, 1, .5, 0.3687814154128256, 1e-12},
        {KILN_DIFFUSE_CHAN2018, .05, 0, 1, .405, 5.01e-4},
    };
    all.insert(all.end(), exact.begin(), exact.end());
    return all;
}

INSTANTIATE_TEST_SUITE_P(Published, DiffuseAnchor, ::testing::ValuesIn(anchors()));

/// Portsmouth, Kutz, Hill 2025, as printed: E of FON at albedo 1, and the albedo of EON.
double fon_albedo(double mu, double r) {
    const double S = std::sqrt(1 - mu * mu), C1 = 0.5 - 2 / (3 * pi);
    const double G = S * (std::acos(mu) - S * mu) + 2 * (S / mu * (1 - S * S * S) - S) / 3;
    return (1 + r * G / pi) / (1 + C1 * r);
}
double eon_albedo(double mu, double r, double rho) {
    const double C1 = 0.5 - 2 / (3 * pi), C2 = 2. / 3 - 28 / (15 * pi);
    const double mean = (1 + C2 * r) / (1 + C1 * r), E = fon_albedo(mu, r);
    return rho * E + rho * rho * mean / (1 - rho * (1 - mean)) * (1 - E);
}

// The quadrature of these smooth integrands is exact to rounding.
TEST(Diffuse, AlbedosOfClosedForm) {
    for (const double mu : {.02, .3, .77, 1.})
        for (const double r : {0., .01, .4, 1.})
            for (const double rho : {.1, .8, 1.}) {
                EXPECT_NEAR(albedo(KILN_DIFFUSE_LAMBERT, mu, r, rho), rho, 1e-13);
                EXPECT_NEAR(albedo(KILN_DIFFUSE_FON, mu, r, rho), rho * fon_albedo(mu, r), 1e-12);
                EXPECT_NEAR(albedo(KILN_DIFFUSE_EON, mu, r, rho), eon_albedo(mu, r, rho), 1e-12);
                if (rho == 1) {
                    EXPECT_NEAR(albedo(KILN_DIFFUSE_EON, mu, r, 1), 1, 1e-12);
                }
            }
    // At normal incidence VoH² = (1 + NoL) / 2, and moments of NoL^p (1 − NoL)^q are left.
    for (const double r : {0., .3, 1.})
        EXPECT_NEAR(albedo(KILN_DIFFUSE_BURLEY, 1, r, 1), 1 + (r - .5) / 21 + r / 84, 1e-13);
    for (const double sigma : {0., .3, 1.}) {
        const double s2 = sigma * sigma;
        EXPECT_NEAR(albedo(KILN_DIFFUSE_OREN_NAYAR, 1, sigma, .7), .7 * (1 - s2 / (2 * s2 + .66)),
                    1e-13);
    }
}

TEST(Diffuse, SmoothLimitsAndBounds) {
    for (const double mu : {1e-3, .05, .5, 1.}) {
        for (const int model :
             {KILN_DIFFUSE_OREN_NAYAR, KILN_DIFFUSE_OREN_NAYAR_FULL, KILN_DIFFUSE_FON,
              KILN_DIFFUSE_EON, KILN_DIFFUSE_EON_UNREAL, KILN_DIFFUSE_CHAN2024})
            EXPECT_NEAR(albedo(model, mu, 0, .6), .6, 1e-13) << model << " at " << mu;
    }
    EXPECT_NEAR(albedo(KILN_DIFFUSE_BURLEY, 1e-9, 1, 1), 1.557540, 1e-6);
    EXPECT_NEAR(albedo(KILN_DIFFUSE_BURLEY, 1e-9, .5, 1), 1.005456, 1e-6);
    EXPECT_NEAR(albedo(KILN_DIFFUSE_BURLEY, 1e-9, 0, 1), .488095, 1e-6);
    // Both forms of Oren-Nayar exceed 1 at grazing views.
    EXPECT_NEAR(albedo(KILN_DIFFUSE_OREN_NAYAR_FULL, 1e-4, .3, 1), 1.051, 1e-3);
    EXPECT_NEAR(albedo(KILN_DIFFUSE_OREN_NAYAR, 1e-4, .2, 1), 1.015, 1e-3);
}

/// The full model with its angles, as Oren and Nayar print it.
double oren_nayar_1994(double NoV, double NoL, double cos_phi, double sigma, double rho) {
    const double a = std::acos(std::min(NoV, NoL)), b = std::acos(std::max(NoV, NoL));
    const double s2 = sigma * sigma, q = 2 * b / pi, p = 4 * a * b / (pi * pi);
    const double C1 = 1 - .5 * s2 / (s2 + .33);
    const double C2 = .45 * s2 / (s2 + .09) * (std::sin(a) - (cos_phi < 0 ? q * q * q : 0));
    const double C3 = .125 * s2 / (s2 + .09) * p * p;
    return rho * (C1 + cos_phi * C2 * std::tan(b) +
                  (1 - std::abs(cos_phi)) * C3 * std::tan((a + b) / 2)) +
           .17 * rho * rho * s2 / (s2 + .13) * (1 - cos_phi * q * q);
}

struct Pair {
    double NoV, NoL, sinL, cos_phi;
};

double sine(double cosine) { return std::sqrt((1 - cosine) * (1 + cosine)); }

/// Random pairs, half of them with both directions within `grazing` of the surface.
std::vector<Pair> pairs(int count, double grazing) {
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> unit(0, 1);
    std::vector<Pair> out;
    for (int i = 0; i < count; ++i) {
        const double scale = i % 2 ? grazing : 1;
        const double NoV = scale * unit(random), NoL = scale * unit(random);
        out.push_back({NoV, NoL, sine(NoL), std::cos(pi * unit(random))});
    }
    return out;
}

TEST(Diffuse, FullOrenNayarIsThePrintedFormula) {
    for (const Pair& p : pairs(20000, .1)) {
        const Directions d = diffuse_directions(p.NoV, p.NoL, p.sinL, p.cos_phi);
        const double printed = oren_nayar_1994(p.NoV, p.NoL, p.cos_phi, .7, .9);
        // The printed form rounds b, whose tangent has the slope 1 / cos² b.
        const double c = std::max(p.NoV, p.NoL), tolerance = 1e-14 + 2e-16 / (c * c);
        EXPECT_NEAR(in_double::diffuse_oren_nayar_full(d, .7, .9), printed, tolerance);
    }
}

TEST(Diffuse, DirectionsAreThoseOfTheVectors) {
    for (const Pair& p : pairs(20000, .1)) {
        const Directions d = diffuse_directions(p.NoV, p.NoL, p.sinL, p.cos_phi);
        const textbook::Vector V = textbook::view(p.NoV);
        const textbook::Vector L = {p.sinL * p.cos_phi, p.sinL * sine(p.cos_phi), p.NoL};
        const textbook::Vector H = textbook::normalized({V[0] + L[0], V[1] + L[1], V[2] + L[2]});
        const double length = 2 * d.VoH;  // |V + L|, whose rounding the vectors' sum magnifies
        EXPECT_NEAR(d.VoH, textbook::dot(V, H), 2e-15 / length);
        EXPECT_NEAR(d.NoH, H[2], 2e-15 / length);
        EXPECT_LE(d.NoH, 1 + 1e-15);
    }
    // Opposite but for ε: V + L = (0, 0, 2 ε), whatever ε is.
    for (const double e : {1e-3, 1e-8, 1e-100}) {
        const Directions d = diffuse_directions(e, e, sine(e), -1);
        EXPECT_NEAR(d.VoH / e, 1, 1e-15);
        EXPECT_NEAR(d.NoH, 1, 1e-15);
    }
}

/// The greatest |f(V, L) − f(L, V)| / f over random pairs.
double irreciprocity(int model) {
    double worst = 0;
    for (const Pair& p : pairs(100000, .1))
        for (const double r : {.05, .5, 1.}) {
            const Directions there = diffuse_directions(p.NoV, p.NoL, p.sinL, p.cos_phi);
            const Directions back = diffuse_directions(p.NoL, p.NoV, sine(p.NoV), p.cos_phi);
            const double a = diffuse_lobe(model, there, r, .7);
            const double b = diffuse_lobe(model, back, r, .7);
            worst = std::max(worst, std::abs(a - b) / std::abs(a + b) * 2);
        }
    return worst;
}

TEST(Diffuse, AllModelsButUnrealsAreReciprocal) {
    for (const int model : kModels)
        if (model == KILN_DIFFUSE_EON_UNREAL)
            EXPECT_GT(irreciprocity(model), 1e-3);
        else
            EXPECT_LE(irreciprocity(model), 4 * 2.3e-16) << model;  // four ulp
}

TEST(Diffuse, ProportionalToAlbedoButForInterreflection) {
    const Directions d = diffuse_directions(.4, .7, sine(.7), -.3);
    for (const int model : kModels) {
        const double ratio = diffuse_lobe(model, d, .8, .4) / diffuse_lobe(model, d, .8, .8);
        const bool mutual = model == KILN_DIFFUSE_OREN_NAYAR_FULL || model == KILN_DIFFUSE_EON ||
                            model == KILN_DIFFUSE_EON_UNREAL;
        if (mutual)
            EXPECT_GT(std::abs(ratio - .5), 1e-3) << model;
        else
            EXPECT_NEAR(ratio, .5, 1e-15) << model;
    }
}

// FON and EON pass through 0 at opposite grazing directions: there, of a fiftieth.
TEST(Diffuse, FloatAgreesWithDouble) {
    for (const int model : kModels) {
        double worst = 0;
        for (const Pair& p : pairs(20000, .01))
            for (const float r : {0.f, .01f, .3f, .75f, 1.f}) {
                const auto NoV = float(p.NoV), NoL = float(p.NoL), sinL = float(p.sinL);
                const auto cos_phi = float(p.cos_phi);
                const double narrow = in_float::diffuse_lobe(
                    model, in_float::diffuse_directions(NoV, NoL, sinL, cos_phi), r, .7f);
                const double wide =
                    diffuse_lobe(model, diffuse_directions(NoV, NoL, sinL, cos_phi), r, .7f);
                worst = std::max(worst, std::abs(narrow - wide) / std::max(std::abs(wide), .02));
            }
        EXPECT_LE(worst, 1e-5) << model;
        if (model != KILN_DIFFUSE_LAMBERT) {
            EXPECT_GT(worst, 1e-8) << model;
        }
    }
}

TEST(Diffuse, ExtremesAreFinite) {
    const std::array<float, 6> cosines = {0, 1e-38f, 1e-20f, 1e-4f, .5f, 1};
    for (const int model : kModels)
        for (const float NoV : cosines)
            for (const float NoL : cosines)
                for (const float cos_phi : {-1.f, -.5f, 0.f, 1.f})
                    for (const float r : {0.f, 1e-20f, 1e-3f, 1.f})
                        for (const float rho : {0.f, .5f, 1.f}) {
                            const float sinL = std::sqrt((1 - NoL) * (1 + NoL));
                            const float f = in_float::diffuse_lobe(
                                model, in_float::diffuse_directions(NoV, NoL, sinL, cos_phi), r,
                                rho);
                            const double wide = diffuse_lobe(
                                model, diffuse_directions(NoV, NoL, sinL, cos_phi), r, rho);
                            EXPECT_TRUE(std::isfinite(f) && std::isfinite(wide))
                                << model << " at NoV " << NoV << " NoL " << NoL << " cos φ "
                                << cos_phi << " r " << r << ": " << f << ", " << wide;
                        }
}

}  // namespace
