// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cmath>
#include <numbers>

// GGX by its published, unsimplified formulas in Cartesian vectors, for tests of kernels/.
namespace textbook {

using Vector = std::array<double, 3>;

inline double dot(const Vector& a, const Vector& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
inline Vector normalized(const Vector& a) {
    const double length = std::sqrt(dot(a, a));
    return {a[0] / length, a[1] / length, a[2] / length};
}
inline Vector view(double NoV) { return {std::sqrt(1 - NoV * NoV), 0, NoV}; }

/// Walter et al. 2007, eq. 33.
inline double D(const Vector& h, double alpha) {
    const double c2 = h[2] * h[2], t2 = (1 - c2) / c2;
    return alpha * alpha /
           (std::numbers::pi * c2 * c2 * (alpha * alpha + t2) * (alpha * alpha + t2));
}
inline double G1(double cosine, double alpha) {
    const double t2 = (1 - cosine * cosine) / (cosine * cosine);
    return 2 / (1 + std::sqrt(1 + alpha * alpha * t2));
}
inline double G2_correlated(double NoV, double NoL, double alpha) {
    return 1 / (1 / G1(NoV, alpha) + 1 / G1(NoL, alpha) - 1);
}

/// Density of visible normals, per solid angle of h (Heitz 2014, eq. 16).
inline double visible_normals(const Vector& h, double NoV, double alpha) {
    const double VoH = dot(view(NoV), h);
    return VoH > 0 && h[2] > 0 ? G1(NoV, alpha) * VoH * D(h, alpha) / NoV : 0;
}
/// Density of all normals, per solid angle of h.
inline double all_normals(const Vector& h, double alpha) {
    return h[2] > 0 ? D(h, alpha) * h[2] : 0;
}

}  // namespace textbook
