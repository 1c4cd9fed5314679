// SPDX-License-Identifier: Apache-2.0
#include "tests/reference/ggx_lambert.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "tests/reference/cosine_average.h"
#include "tests/reference/facet_rings.h"
#include "tests/reference/microfacet_models.h"
#include "tests/reference/tanh_sinh.h"

namespace kiln::reference {
namespace {

constexpr double kPi = std::numbers::pi;

void check(double alpha, double cosine) {
    if (!(alpha >= 1e-3 && alpha <= 1 && cosine >= 1e-4 && cosine <= 1))
        throw std::domain_error("reference: alpha or a cosine outside [1e-3, 1] x [1e-4, 1]");
}

double joint_masking(double alpha, double NoV, double NoL, Masking masking) {
    const double v = smith_lambda(Distribution::ggx, alpha, NoV);
    const double l = smith_lambda(Distribution::ggx, alpha, NoL);
    return masking == Masking::correlated ? 1 / (1 + v + l) : 1 / ((1 + v) * (1 + l));
}

}  // namespace

double ggx_lambert_single_albedo(double alpha, double NoV, Masking masking) {
    check(alpha, NoV);
    const double sin_v = std::sqrt((1 - NoV) * (1 + NoV)), e_v = std::asin(NoV);
    return converge(
        [&](int level) {
            const TanhSinh& rule = tanh_sinh(level);
            double sum = 0;
            // V and L stop seeing the whole ring of normals at the same slope where e = e_v.
            for (const auto& [begin, length] : {std::pair{0.0, e_v}, {e_v, kPi / 2 - e_v}})
                for (std::size_t j = 0; j < rule.weight.size(); ++j) {
                    const double e = begin + length * rule.from0[j];
                    const double NoL = std::sin(e), sin_l = std::cos(e);
                    const double weight = length * rule.weight[j] * sin_l;
                    if (weight < 1e-17 || NoL < 1e-15) continue;
                    const auto both = [&](double cos_m, double sin_m) {
                        return visible_cosine(NoV, sin_v, cos_m, sin_m) *
                               visible_cosine(NoL, sin_l, cos_m, sin_m);
                    };
                    sum += weight * joint_masking(alpha, NoV, NoL, masking) *
                           over_normals(alpha, {NoV / sin_v, NoL / sin_l}, rule, both);
                }
            return sum / (kPi * NoV);
        },
        1e-6, 0, Magnitude{});
}

double ggx_lambert_single_average(double alpha, Masking masking) {
    return cosine_average([&](double mu) { return ggx_lambert_single_albedo(alpha, mu, masking); },
                          {}, 1e-4);
}

double ggx_lambert_single(double alpha, double NoV, double NoL, double cos_delta_phi,
                          Masking masking) {
    check(alpha, NoV);
    check(alpha, NoL);
    const double sin_v = std::sqrt((1 - NoV) * (1 + NoV));
    const double sin_l = std::sqrt((1 - NoL) * (1 + NoL));
    const double delta = std::acos(std::clamp(cos_delta_phi, -1.0, 1.0));
    // Both ends of visibility meet at the normal that is perpendicular to V and to L.
    const double nx = -NoV * sin_l * std::sin(delta);
    const double ny = NoV * sin_l * std::cos(delta) - sin_v * NoL;
    const double meeting = std::sqrt(nx * nx + ny * ny) / std::abs(sin_v * sin_l * std::sin(delta));
    const auto ring = [&](double cos_m, double sin_m, const TanhSinh& rule) {
        const double half_v = visible_azimuth(NoV, sin_v, cos_m, sin_m);
        const double half_l = visible_azimuth(NoL, sin_l, cos_m, sin_m);
        std::vector<double> ends{-half_v, half_v};
        for (const double end : {delta - half_l, delta + half_l})
            for (const double turn : {-2 * kPi, 0.0, 2 * kPi})
                if (std::abs(end + turn) < half_v) ends.push_back(end + turn);
        std::sort(ends.begin(), ends.end());
        double sum = 0;
        for (std::size_t part = 0; part + 1 < ends.size(); ++part) {
            const double length = ends[part + 1] - ends[part];
            for (std::size_t j = 0; j < rule.weight.size(); ++j) {
                const double phi = ends[part] + length * rule.from0[j];
                const double v = NoV * cos_m + sin_v * sin_m * std::cos(phi);
                const double l = NoL * cos_m + sin_l * sin_m * std::cos(phi - delta);
                sum += length * rule.weight[j] * std::max(0.0, v) * std::max(0.0, l);
            }
        }
        return sum;
    };
    const double integral = converge(
        [&](int level) {
            const TanhSinh& rule = tanh_sinh(level);
            return over_normals(alpha, {NoV / sin_v, NoL / sin_l, meeting}, rule,
                                [&](double c, double s) { return ring(c, s, rule); });
        },
        0, 1e-5, Magnitude{});
    return joint_masking(alpha, NoV, NoL, masking) * integral / (kPi * NoV * NoL);
}

}  // namespace kiln::reference
