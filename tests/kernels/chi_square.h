// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/kernels/textbook.h"

/// What tests of samplers count: directions by their place on [0, 1] x [0, pi].
namespace chi_square {

/// A direction's place: t in [0, 1] grows with its polar angle, phi in [0, pi] is its azimuth from
/// the view, folded.
struct Place {
    double t, phi;
};

/// A half vector's: tan θ = α tan(π t / 2), which spreads any width over [0, 1], smoothly at both
/// ends. From its component along the view's azimuth and its height.
inline Place place_of_normal(double x, double z, double alpha) {
    const double sine = std::sqrt(1 - z * z);
    return {std::atan(sine / z / alpha) * 2 / std::numbers::pi,
            std::acos(std::clamp(x / std::max(sine, 1e-12), -1.0, 1.0))};
}

/// The half vector at a place, and the solid angle of both signs of y by dt dphi.
struct PlacedNormal {
    textbook::Vector h;
    double solid;
};
inline PlacedNormal normal_at(double t, double phi, double alpha) {
    const double turn = std::numbers::pi / 2, tangent = std::tan(turn * t);
    const double z = 1 / std::sqrt(1 + alpha * alpha * tangent * tangent);
    const double sine = alpha * tangent * z;
    // dω = sinθ dθ dφ, dθ = z² d tanθ.
    const double solid = sine * z * z * alpha * turn * (1 + tangent * tangent);
    return {{sine * std::cos(phi), sine * std::sin(phi), z}, 2 * solid};
}

/// One-sided probability of a statistic this large or larger. Wilson, Hilferty 1931: the cube root
/// of chi square over its degrees is nearly normal.
inline double p_value(double statistic, int degrees) {
    const double k = 2.0 / (9 * degrees);
    return 0.5 * std::erfc((std::cbrt(statistic / degrees) - (1 - k)) / std::sqrt(2 * k));
}

}  // namespace chi_square
