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

}  // namespace

double adaptive_integral(const std::function<double(double)>& value, double from, double to,
                         double absolute) {
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

}  // namespace kiln
