// SPDX-License-Identifier: Apache-2.0
#include "server/measured/predicted_error.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "server/measured/material.h"

namespace kiln::measured {
namespace {

/// Of a second difference over steps a and b, a b / 2 times the curvature, what a linear
/// interpolation over a gap g is off by on the mean: g^2 / 12 times the curvature.
constexpr double kSixth = 1.0 / 6;

double sum_of(const Colour& c) { return c[0] + c[1] + c[2]; }

/// How far incidence n lies from the mean of its neighbours about the mirror direction.
double left_out(const Material& material, std::size_t n) {
    const std::vector<double> theta = material.theta_in();
    const double share = (theta[n] - theta[n - 1]) / (theta[n + 1] - theta[n - 1]);
    constexpr int kViews = 1500;
    double off = 0, all = 0;
    for (int v = 0; v < kViews; ++v) {  // the golden spiral on the disk of projected solid angle
        const double r2 = (v + 0.5) / kViews, turn = v * std::numbers::pi * (3 - std::sqrt(5.0));
        const Vec out = {std::sqrt(r2) * std::cos(turn), std::sqrt(r2) * std::sin(turn),
                         std::sqrt(1 - r2)};
        const Vec d = to_mirror(theta[n], out);
        double f[3] = {};
        bool measured = true;
        for (std::size_t k = 0; k < 3; ++k) {
            Origin origin{};
            f[k] = sum_of(material.lobe_value(n + k - 1, from_mirror(theta[n + k - 1], d), origin));
            measured = measured && origin != Origin::kExtrapolated;
        }
        if (!measured) continue;
        off += std::abs((1 - share) * f[0] + share * f[2] - f[1]);
        all += std::abs(f[1]);
    }
    return all > 0 ? off / all : 0;
}

}  // namespace

double points_error(const Material& material, std::size_t lobe) {
    double off = 0, all = 0;
    for (std::uint64_t round = 0; round < 3; ++round) {
        const Hemisphere::Prediction part = material.hemisphere(lobe).leave_regions_out(round);
        off += part.off;
        all += part.all;
    }
    return all > 0 ? kSixth * off / all : 0;
}

std::vector<double> theta_in_errors(const Material& material) {
    const std::vector<double> theta = material.theta_in();
    if (theta.size() < 3) return {};
    std::vector<double> curvature(theta.size());
    for (std::size_t n = 1; n + 1 < theta.size(); ++n)
        curvature[n] =
            2 * left_out(material, n) / ((theta[n] - theta[n - 1]) * (theta[n + 1] - theta[n]));
    curvature.front() = curvature[1];
    curvature.back() = curvature[theta.size() - 2];
    std::vector<double> errors;
    for (std::size_t n = 0; n + 1 < theta.size(); ++n) {
        const double gap = theta[n + 1] - theta[n];
        errors.push_back(gap * gap / 12 * 0.5 * (curvature[n] + curvature[n + 1]));
    }
    return errors;
}

PredictedError predict_error(const Material& material) {
    PredictedError error;
    const auto lobes = static_cast<double>(material.lobe_count());
    for (std::size_t n = 0; n < material.lobe_count(); ++n)
        error.points += points_error(material, n) / lobes;
    const std::vector<double> gaps = theta_in_errors(material);
    error.knows_theta_in = !gaps.empty();
    for (const double gap : gaps) error.theta_in += gap / static_cast<double>(gaps.size());
    return error;
}

}  // namespace kiln::measured
