// SPDX-License-Identifier: Apache-2.0
#include "tests/reference/diffuse_models.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>

namespace kiln::reference {
namespace {

constexpr double kPi = std::numbers::pi;

/// A pair of directions as the models want it.
struct Pair {
    double NoV, NoL, cos_phi;
    double VoL, VoH, NoH;

    Pair(double v, double l, double c) : NoV(v), NoL(l), cos_phi(c) {
        VoL = v * l + std::sqrt((1 - v * v) * (1 - l * l)) * c;
        VoH = std::sqrt(std::max(0.0, (1 + VoL) / 2));
        // |V + L| = 2 VoH.
        NoH = std::min(1.0, (v + l) / (2 * VoH));
    }
};

double power5(double x) { return x * x * x * x * x; }

double burley(double r, const Pair& p) {
    const double f90 = 0.5 + 2 * r * p.VoH * p.VoH;
    return (1 + (f90 - 1) * power5(1 - p.NoL)) * (1 + (f90 - 1) * power5(1 - p.NoV)) / kPi;
}

double burley_normalized(double r, const Pair& p) {
    const double bias = 0.5 * r, factor = 1 + r * (1 / 1.51 - 1);
    const double f90 = bias + 2 * p.VoH * p.VoH * r;
    return factor * (1 + (f90 - 1) * power5(1 - p.NoL)) * (1 + (f90 - 1) * power5(1 - p.NoV)) / kPi;
}

/// sin(a) tan(b), a the larger and b the smaller of the polar angles.
double oren_nayar(double sigma, const Pair& p) {
    const double s2 = sigma * sigma;
    const double a = std::acos(std::min(p.NoV, p.NoL)), b = std::acos(std::max(p.NoV, p.NoL));
    return (1 - s2 / (2 * (s2 + 0.33)) +
            0.45 * s2 / (s2 + 0.09) * std::max(0.0, p.cos_phi) * std::sin(a) * std::tan(b)) /
           kPi;
}

double oren_nayar_full(double sigma, double rho, const Pair& p) {
    const double s2 = sigma * sigma;
    const double a = std::acos(std::min(p.NoV, p.NoL)), b = std::acos(std::max(p.NoV, p.NoL));
    const double share = 2 * b / kPi;
    const double c1 = 1 - 0.5 * s2 / (s2 + 0.33);
    const double c2 = 0.45 * s2 / (s2 + 0.09) *
                      (p.cos_phi >= 0 ? std::sin(a) : std::sin(a) - share * share * share);
    const double c3 = 0.125 * s2 / (s2 + 0.09) * std::pow(4 * a * b / (kPi * kPi), 2);
    const double direct =
        c1 + p.cos_phi * c2 * std::tan(b) + (1 - std::abs(p.cos_phi)) * c3 * std::tan((a + b) / 2);
    const double interreflected = 0.17 * s2 / (s2 + 0.13) * (1 - p.cos_phi * share * share);
    return (rho * direct + rho * rho * interreflected) / kPi;
}

constexpr double kFon1 = 0.5 - 2 / (3 * kPi);
constexpr double kFon2 = 2.0 / 3 - 28 / (15 * kPi);

double fon(double r, const Pair& p) {
    const double s = p.VoL - p.NoV * p.NoL;
    const double t = s > 0 ? std::max(p.NoV, p.NoL) : 1;
    return (1 + r * s / t) / (1 + kFon1 * r) / kPi;
}

double eon(double r, double rho, const Pair& p) {
    const double average = (1 + kFon2 * r) / (1 + kFon1 * r);
    if (r == 0) return rho / kPi;
    const double rho_ms = rho * rho * average / (1 - rho * (1 - average));
    return rho * fon(r, p) +
           rho_ms / kPi * (1 - fon_albedo(r, p.NoV)) * (1 - fon_albedo(r, p.NoL)) / (1 - average);
}

/// Diffuse_EON of Unreal 5.7: its colour inversion, straight-line A_F and first-order albedo.
double eon_unreal(double R, double colour, const Pair& p) {
    const double rho = colour * (1 + (0.189468 - 0.189468 * colour) * R);
    const double s = p.VoL - p.NoV * p.NoL;
    const double s_over_t = std::max(s / std::max(1e-6, std::max(p.NoV, p.NoL)), s);
    const double af = 1 - R * (1 - 1 / (1 + kFon1));
    const double single = af * (1 + R * s_over_t);
    const double multiple = 1 - af * (1 + R * 0.262048 * (1 - p.NoV));
    return rho * (single + rho * multiple) / kPi;
}

double chan2018(double R, const Pair& p) {
    const double g = std::clamp(std::log2(2 / std::pow(R, 4) - 1) / 18, 0.0, 1.0);
    const double rough = p.VoH + power5(1 - p.VoH);
    const double smooth = (1 - 0.75 * power5(1 - p.NoV)) * (1 - 0.75 * power5(1 - p.NoL));
    const double mix = std::clamp(2.2 * g - 0.5, 0.0, 1.0);
    const double retro = ((34.5 * g - 59) * g + 24.5) * p.VoH *
                         std::exp2(-std::max(73.2 * g - 21.2, 8.9) * std::sqrt(p.NoH));
    return (rough + (smooth - rough) * mix + retro) / kPi;
}

double chan2024(double R, const Pair& p) {
    const double scale = std::max(0.55 - 0.2 * R, 1.25 - 1.6 * R);
    const double bias = std::clamp(4 * R * R, 0.0, 1.0);
    const double rough = scale * (p.NoH + bias) / (p.NoH + 0.025) * p.VoH * p.VoH;
    return (1 + (rough - 1) * R + 0.38 * R * R) / kPi;
}

}  // namespace

double fon_albedo(double roughness, double NoV) {
    const double S = std::sqrt((1 - NoV) * (1 + NoV));
    const double g = S * (std::acos(NoV) - S * NoV) + 2.0 / 3 * (S / NoV * (1 - S * S * S) - S);
    return (1 + roughness * g / kPi) / (1 + kFon1 * roughness);
}

DiffuseModel diffuse_model(std::string_view word) {
    using enum DiffuseModel;
    const std::pair<std::string_view, DiffuseModel> words[] = {
        {"lambert", lambert},
        {"burley", burley},
        {"burley_normalized", burley_normalized},
        {"oren_nayar", oren_nayar},
        {"oren_nayar_full", oren_nayar_full},
        {"fon", fon},
        {"eon", eon},
        {"eon_unreal", eon_unreal},
        {"chan2018", chan2018},
        {"chan2024", chan2024},
    };
    for (const auto& [known, model] : words)
        if (known == word) return model;
    throw std::domain_error("reference: no diffuse model " + std::string(word));
}

double diffuse_brdf(const Diffuse& lobe, double NoV, double NoL, double cos_delta_phi) {
    const Pair p(NoV, NoL, cos_delta_phi);
    const double r = lobe.roughness, rho = lobe.albedo;
    switch (lobe.model) {
        case DiffuseModel::lambert:
            return rho / kPi;
        case DiffuseModel::burley:
            return rho * burley(r, p);
        case DiffuseModel::burley_normalized:
            return rho * burley_normalized(r, p);
        case DiffuseModel::oren_nayar:
            return rho * oren_nayar(r, p);
        case DiffuseModel::oren_nayar_full:
            return oren_nayar_full(r, rho, p);
        case DiffuseModel::fon:
            return rho * fon(r, p);
        case DiffuseModel::eon:
            return eon(r, rho, p);
        case DiffuseModel::eon_unreal:
            return eon_unreal(r, rho, p);
        case DiffuseModel::chan2018:
            return rho * std::min(1.0, chan2018(r, p));
        case DiffuseModel::chan2018_no_clamp:
            return rho * chan2018(r, p);
        case DiffuseModel::chan2024:
            return rho * chan2024(r, p);
    }
    throw std::domain_error("reference: unknown diffuse model");
}

}  // namespace kiln::reference
