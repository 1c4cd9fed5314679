// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <cmath>
#include <numbers>

namespace kiln::measured {

inline constexpr double kDegree = std::numbers::pi / 180.0;

/// A direction; unit length unless said otherwise, z along the normal.
struct Vec {
    double x = 0, y = 0, z = 0;
};

inline Vec operator+(Vec a, Vec b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec operator-(Vec a, Vec b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec operator*(double s, Vec a) { return {s * a.x, s * a.y, s * a.z}; }
inline double dot(Vec a, Vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

/// Angles in degrees.
inline Vec direction(double theta, double phi) {
    const double s = std::sin(theta * kDegree);
    return {s * std::cos(phi * kDegree), s * std::sin(phi * kDegree), std::cos(theta * kDegree)};
}

/// Degrees in [0, 180]; well conditioned near the pole, unlike acos.
inline double theta_of(Vec a) { return std::atan2(std::hypot(a.x, a.y), a.z) / kDegree; }
/// Degrees in (-180, 180]; 0 at the pole.
inline double phi_of(Vec a) { return a.x == 0 && a.y == 0 ? 0.0 : std::atan2(a.y, a.x) / kDegree; }

/// The direction at the angle `radial` from the mirror direction of light at (theta_i, phi_i), at
/// `azimuth` about it, counter-clockwise as seen against it, 0 towards the normal. Degrees.
inline Vec about_mirror(double theta_i, double phi_i, double radial, double azimuth) {
    const Vec mirror = direction(theta_i, phi_i + 180.0);
    const Vec to_normal = direction(theta_i - 90.0, phi_i + 180.0);
    const Vec side = {mirror.y * to_normal.z - mirror.z * to_normal.y,
                      mirror.z * to_normal.x - mirror.x * to_normal.z,
                      mirror.x * to_normal.y - mirror.y * to_normal.x};
    const double s = std::sin(radial * kDegree);
    return std::cos(radial * kDegree) * mirror + (s * std::cos(azimuth * kDegree)) * to_normal +
           (s * std::sin(azimuth * kDegree)) * side;
}

/// From the frame about the mirror direction of light at theta_in to that of the surface, equation
/// 15 of Cezner 2024: rows (-c, 0, -s), (0, -1, 0), (-s, 0, c). It is its own inverse.
inline Vec from_mirror(double theta_in, Vec d) {
    const double c = std::cos(theta_in * kDegree), s = std::sin(theta_in * kDegree);
    return {-c * d.x - s * d.z, -d.y, -s * d.x + c * d.z};
}
inline Vec to_mirror(double theta_in, Vec v) { return from_mirror(theta_in, v); }

}  // namespace kiln::measured
