// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <numbers>
#include <vector>

#include "tests/reference/microfacet_models.h"
#include "tests/reference/tanh_sinh.h"

/// GGX normals m by rings of one polar angle, and what a direction d of the whole sphere sees of
/// a ring.
namespace kiln::reference {

// Normals steeper than this slope hold less than 1e-10 of the integral.
inline constexpr double kSteepest = 1e10;

/// Where <d, m> turns negative as m turns away from d's azimuth.
inline double visible_azimuth(double cos_d, double sin_d, double cos_m, double sin_m) {
    if (sin_d * sin_m == 0) return cos_d > 0 ? std::numbers::pi : 0;
    return std::acos(std::clamp(-cos_d * cos_m / (sin_d * sin_m), -1.0, 1.0));
}

/// Integral of <d, m> over the azimuth of m.
inline double visible_cosine(double cos_d, double sin_d, double cos_m, double sin_m) {
    const double phi = visible_azimuth(cos_d, sin_d, cos_m, sin_m);
    return 2 * (phi * cos_d * cos_m + sin_d * sin_m * std::sin(phi));
}

/// Integral over the polar angle theta of D(theta) sin(theta) inner(cos, sin), with tan(theta) =
/// alpha sinh v, split at the given slopes.
template <class Inner>
double over_normals(double alpha, std::initializer_list<double> slopes, const TanhSinh& rule,
                    const Inner& inner) {
    std::vector<double> ends{0, std::asinh(kSteepest / alpha)};
    for (const double slope : slopes)
        if (slope > 0 && slope < kSteepest) ends.push_back(std::asinh(slope / alpha));
    std::sort(ends.begin(), ends.end());
    double sum = 0;
    for (std::size_t part = 0; part + 1 < ends.size(); ++part) {
        const double length = ends[part + 1] - ends[part];
        for (std::size_t j = 0; j < rule.weight.size(); ++j) {
            const double v = ends[part] + length * rule.from0[j];
            const double t = alpha * std::sinh(v), cos_m = 1 / std::sqrt(1 + t * t);
            const double weight = length * rule.weight[j] * alpha * std::cosh(v) * cos_m * cos_m *
                                  distribution(Distribution::ggx, alpha, t) * t * cos_m;
            if (weight < 1e-19) continue;
            sum += weight * inner(cos_m, t * cos_m);
        }
    }
    return sum;
}

}  // namespace kiln::reference
