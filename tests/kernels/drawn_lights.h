// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cmath>

#include "tests/kernels/one_lane.h"
#include "tests/kernels/textbook.h"

/// What half vectors drawn above the horizon stand for, by differences.
namespace drawn_lights {

using textbook::Vector;

struct Setting {
    double NoV, alpha;
};

inline Vector half_vector(const Setting& at, const in_double::VisibleLight& sample) {
    const double S = in_double::ggx_view(at.NoV, at.alpha).S, length = std::sqrt(sample.h.hh);
    const double z = sample.NoH / length, VoH = S * sample.h.VoH2 / 2 / length;
    const double x = (VoH - at.NoV * z) / std::sqrt(1 - at.NoV * at.NoV);
    return {x, std::sqrt(std::max(0.0, 1 - x * x - z * z)), z};
}

inline double light_elevation(const Setting& at, const Vector& h) {
    return 2 * textbook::dot(textbook::view(at.NoV), h) * h[2] - at.NoV;
}

inline Vector cross(const Vector& a, const Vector& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// Central differences, of the fourth order.
Vector slope(const auto& f, double step) {
    Vector d{};
    const Vector a = f(-2 * step), b = f(-step), c = f(step), e = f(2 * step);
    for (std::size_t i = 0; i < 3; ++i) d[i] = (a[i] - 8 * b[i] + 8 * c[i] - e[i]) / (12 * step);
    return d;
}

/// Of the sphere, for a step of both arguments of `direction` from where it stands.
double area_at(const auto& direction, double step) {
    const Vector by_phi = slope([&](double d) { return direction(d, 0); }, step);
    const Vector by_t = slope([&](double d) { return direction(0, d); }, step);
    const Vector area = cross(by_phi, by_t);
    return std::sqrt(textbook::dot(area, area));
}

/// Visible normals that a point of the unit square, dφ dt / π of either half, stands for:
/// sample(by φ, by t) from where it stands.
double normals_at(const Setting& at, const auto& sample, double step) {
    const auto normal = [&](double by_phi, double by_t) {
        return half_vector(at, sample(by_phi, by_t));
    };
    return 2 * std::numbers::pi * area_at(normal, step) *
           textbook::visible_normals(normal(0, 0), at.NoV, at.alpha);
}

}  // namespace drawn_lights
