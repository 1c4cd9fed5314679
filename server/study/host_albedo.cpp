// SPDX-License-Identifier: Apache-2.0
#include "server/study/host_albedo.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "server/compute/one_lane.h"
#include "server/compute/quadrature.h"

namespace kiln {

namespace {

constexpr unsigned kFine = 20;  // and half of it, which comes with it
constexpr int kHalvings = 24;

/// A vector of integrals at once.
template <std::size_t N, typename Value>
std::array<double, N> integral(const Value& value, double from, double to, double absolute,
                               int depth = 0) {
    static const std::vector<double> nodes = gauss_legendre({kFine, kFine / 2});
    std::array<double, N> fine{}, coarse{};
    for (unsigned i = 0; i < kFine + kFine / 2; ++i) {
        const auto at = value(from + (to - from) * nodes[2 * i]);
        auto& sum = i < kFine ? fine : coarse;
        for (std::size_t k = 0; k < N; ++k) sum[k] += (to - from) * nodes[2 * i + 1] * at[k];
    }
    double apart = 0, size = 0;
    for (std::size_t k = 0; k < N; ++k) {
        apart = std::max(apart, std::abs(fine[k] - coarse[k]));
        size = std::max(size, std::abs(fine[k]));
    }
    if (apart <= std::max(absolute, 1e-13 * size) || depth == kHalvings) return fine;
    const double middle = 0.5 * (from + to);
    const auto left = integral<N>(value, from, middle, 0.5 * absolute, depth + 1);
    const auto right = integral<N>(value, middle, to, 0.5 * absolute, depth + 1);
    for (std::size_t k = 0; k < N; ++k) fine[k] = left[k] + right[k];
    return fine;
}

double sine(double cosine) { return std::sqrt((1 - cosine) * (1 + cosine)); }

/// Integral over phi of max(0, cosine + slope sine cos phi): what a direction sees of all facets of
/// one slope, a unit of their projected area.
double seen_of_slope(double cosine, double sine, double slope) {
    constexpr double pi = std::numbers::pi;
    if (cosine >= slope * sine) return 2 * pi * cosine;
    const double end = std::acos(-cosine / (slope * sine));
    return 2 * (cosine * end + slope * sine * std::sin(end));
}

}  // namespace

double adaptive_integral(const std::function<double(double)>& value, double from, double to,
                         double absolute) {
    if (from == to) return 0;
    return integral<1>([&](double x) { return std::array{value(x)}; }, from, to, absolute)[0];
}

// With t = tan of the half vector's angle to the normal: NoL (1 + t²) = NoV (1 − t²) + 2 sinV t
// cos φ, which is positive up to an azimuth in closed form, and nowhere from t = cot(e / 2) on, e
// the view's elevation. t = w sinh v is as dense as D is narrow.
HostAlbedo host_albedo(const KernelMaterial& lobe, double NoV, double alpha, double absolute,
                       const HostFresnel& fresnel) {
    const bool charlie = lobe.distribution == KILN_DISTRIBUTION_CHARLIE;
    const double width = charlie ? 1 : alpha, sinV = sine(NoV);
    const auto along = [&](double v) -> std::array<double, 2> {
        const double t = width * std::sinh(v), t2 = t * t;
        const double up = NoV * (1 - t2), side = 2 * sinV * t;
        if (side + up <= 0) return {};
        const double end =
            up >= side ? std::numbers::pi : 2 * std::atan(std::sqrt((side + up) / (side - up)));
        const double inverse = 1 / (1 + t2), NoH = std::sqrt(inverse), sin2_H = t2 * inverse;
        const double D = one_lane::microfacet_D(lobe.distribution, alpha, NoV, NoH, sin2_H);
        const double measure =
            D * t * inverse * NoH * width * std::cosh(v) * 2;  // both sides of the azimuth
        if (!(measure > 0)) return {};
        const auto around = [&](double phi) -> std::array<double, 2> {
            const double cos_phi = std::cos(phi);
            one_lane::Scattering s{};
            s.NoV = NoV;
            s.sinV = sinV;
            s.NoL = std::clamp((up + side * cos_phi) * inverse, 0.0, 1.0);
            s.sinL = sine(s.NoL);
            s.VoH = std::clamp(NoH * (NoV + sinV * t * cos_phi), 0.0, 1.0);
            s.NoH = NoH;
            s.sin2_H = sin2_H;
            if (!(s.NoL > 0)) return {};
            const double f =
                one_lane::microfacet_visibility(lobe.distribution, lobe.masking, alpha, s) * 4 *
                s.VoH * s.NoL * measure;
            return {f,
                    f * (fresnel.F ? fresnel.F(s.VoH) : one_lane::fresnel_schlick_weight(s.VoH))};
        };
        const double at = (fresnel.kink / NoH - NoV) / (sinV * t);
        if (!(std::abs(at) < 1) || std::acos(at) >= end)
            return integral<2>(around, 0, end, absolute);
        auto sum = integral<2>(around, 0, std::acos(at), absolute);
        const auto rest = integral<2>(around, std::acos(at), end, absolute);
        for (std::size_t k = 0; k < 2; ++k) sum[k] += rest[k];
        return sum;
    };
    const double horizon = NoV / (1 + sinV);  // tan of half the elevation
    const double end = std::asinh(std::min(1 / horizon, 1e12) / width);
    const double kink = std::min(std::asinh(horizon / width), end);
    std::array<double, 2> sum{};
    std::vector<double> ends{0};
    for (double v = 1; v < kink; v += 2) ends.push_back(v);
    ends.push_back(kink);
    for (double v = kink + 1; v < end; v += 2) ends.push_back(v);
    ends.push_back(end);
    for (std::size_t i = 0; i + 1 < ends.size(); ++i) {
        const auto part = integral<2>(along, ends[i], ends[i + 1], absolute);
        for (std::size_t k = 0; k < 2; ++k) sum[k] += part[k];
    }
    return {sum[0], sum[1]};
}

double host_diffuse_albedo(int model, double NoV, double roughness, double albedo,
                           double absolute) {
    const auto at = [&](double NoL) {
        const auto around = [&](double phi) {
            const auto d = one_lane::diffuse_directions(NoV, NoL, sine(NoL), std::cos(phi));
            return one_lane::diffuse_lobe(model, d, roughness, albedo);
        };
        constexpr double pi = std::numbers::pi;
        return 2 * NoL / pi *
               (adaptive_integral(around, 0, pi / 2, absolute) +
                adaptive_integral(around, pi / 2, pi, absolute));
    };
    return adaptive_integral(at, 0, NoV, absolute) + adaptive_integral(at, NoV, 1, absolute);
}

// The slope is alpha sinh v, whose share of the projected area is 2 tanh v / cosh^2 v dv; e^-40 is
// beyond the end. The azimuths of V and of L about a facet separate, and the area that V sees,
// NoV (1 + Lambda), is finite at grazing.
double host_single_facet_albedo(double NoV, double alpha, double absolute) {
    constexpr double pi = std::numbers::pi, end = 40;
    const double sinV = sine(NoV), visible = (NoV + std::hypot(NoV, alpha * sinV)) / 2;
    const auto of_slope = [&](double v) {
        const double slope = alpha * std::sinh(v), cosine = 1 / std::sqrt(1 + slope * slope);
        const auto towards = [&](double NoL) {
            const double sinL = sine(NoL), stretched = alpha * sinL;
            const double masked = stretched * stretched / (NoL + std::hypot(NoL, stretched));
            const double leaves = 2 * NoL * visible / (2 * NoL * visible + NoV * masked);
            return leaves * cosine * seen_of_slope(NoL, sinL, slope) / pi;
        };
        const double fold = slope * cosine;  // lights below it see a part of them
        const double share = std::tanh(v) / (std::cosh(v) * std::cosh(v)) / pi;
        return share * seen_of_slope(NoV, sinV, slope) / visible *
               (adaptive_integral(towards, 0, fold, absolute) +
                adaptive_integral(towards, fold, 1, absolute));
    };
    const double fold = std::min(std::asinh(NoV / (alpha * sinV)), end);
    return adaptive_integral(of_slope, 0, fold, absolute) +
           adaptive_integral(of_slope, fold, end, absolute);
}

}  // namespace kiln
