// SPDX-License-Identifier: Apache-2.0
#include "server/measured/predicted_error.h"

#include <algorithm>
#include <cmath>

#include "server/measured/material.h"

namespace kiln::measured {
namespace {

/// Of a second difference over steps a and b, a b / 2 times the curvature, what a linear
/// interpolation over a gap g is off by on the mean: g^2 / 12 times the curvature.
constexpr double kSixth = 1.0 / 6;

/// Mean over a gap of Reach::length to the power of its order.
double mean_power(const std::vector<double>& theta, std::size_t gap, Between between) {
    constexpr int kSteps = 8;
    double sum = 0;
    for (int k = 0; k < kSteps; ++k) {
        const double at = theta[gap] + (theta[gap + 1] - theta[gap]) * (k + 0.5) / kSteps;
        const Reach reach = reach_of(theta, at, between);
        sum += std::pow(reach.length, reach.order) / kSteps;
    }
    return sum;
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
    const std::vector<IncidenceError> left = leave_incidences_out(material, material.between());
    if (left.empty()) return {};
    std::vector<double> errors;
    for (std::size_t gap = 0; gap + 1 < theta.size(); ++gap) {
        const double power = mean_power(theta, gap, material.between());
        const double order =
            reach_of(theta, 0.5 * (theta[gap] + theta[gap + 1]), material.between()).order;
        // The mean of what both ends say, the nearest inner one where an end is none.
        double sum = 0;
        for (const std::size_t end : {gap, gap + 1}) {
            const IncidenceError& one = left[std::clamp<std::size_t>(end, 1, theta.size() - 2) - 1];
            sum += 0.5 * one.error * power / std::pow(one.reach, order);
        }
        errors.push_back(sum);
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
    error.azimuths = material.azimuths().error;
    return error;
}

}  // namespace kiln::measured
