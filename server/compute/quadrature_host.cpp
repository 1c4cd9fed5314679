// SPDX-License-Identifier: Apache-2.0
// The kernel at one lane in double: what the reports' reference values come from.
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

#include "server/compute/one_lane.h"
#include "server/compute/quadrature.h"

namespace kiln {

namespace {

using namespace one_lane;

// A tenth of what is promised.
constexpr double kAbsolute = 1e-10, kDeficitRelative = 1e-7;

const std::vector<double>& nodes_of(std::size_t step) {
    static const auto tables = [] {
        std::array<std::vector<double>, std::size(kQuadratureOrders)> all;
        std::transform(std::begin(kQuadratureOrders), std::end(kQuadratureOrders), all.begin(),
                       quadrature_nodes);
        return all;
    }();
    return tables[step];
}

QuadratureValue at_order(double NoV, double alpha, Masking masking, bool fresnel,
                         std::size_t step) {
    const unsigned order = kQuadratureOrders[step];
    const Albedo albedo = quadrature(static_cast<int>(masking), fresnel ? 1 : 0, NoV, alpha,
                                     nodes_of(step).data(), order);
    return {albedo.E, albedo.B, albedo.deficit, 0, 0, order};
}

QuadratureValue settle(double NoV, double alpha, Masking masking, bool fresnel) {
    QuadratureValue lower = at_order(NoV, alpha, masking, fresnel, kQuadratureTightStart);
    for (std::size_t step = kQuadratureTightStart + 1;; ++step) {
        QuadratureValue value = at_order(NoV, alpha, masking, fresnel, step);
        value.error = std::max(std::abs(value.E - lower.E), std::abs(value.B - lower.B));
        if (value.deficit > 0)
            value.deficit_error = std::abs(value.deficit - lower.deficit) / value.deficit;
        const bool agree = value.error <= kAbsolute && value.deficit_error <= kDeficitRelative;
        if (agree || step + 1 == std::size(kQuadratureOrders)) return value;
        lower = value;
    }
}

/// The view's cosine is alpha w (v^-8 - 1), as in kernels/ray.h, and v is linear in the square of
/// the node: 1 - E goes like NoV log NoV at the horizon, which the square takes to the 12th order.
double average_deficit_at(double alpha, Masking masking, unsigned order) {
    const std::vector<double> nodes = quadrature_nodes(order);
    const double width = std::min(0.7 * alpha, 0.5);
    const double slope = std::pow(1 + 1 / width, -0.125) - 1;
    double sum = 0;
    for (std::size_t i = 0; i < order; ++i) {
        const double u = nodes[2 * i], v = 1 + slope * (u * u);
        const double growth = std::pow(v, -8);
        const double NoV = std::min(1.0, width * (growth - 1));
        const double dNoV = -16 * width * slope * u * growth / v;
        sum += nodes[2 * i + 1] * dNoV * NoV * quadrature_deficit(NoV, alpha, masking);
    }
    return 2 * sum;
}

}  // namespace

QuadratureValue quadrature_albedo(double NoV, double alpha, Masking masking) {
    return settle(NoV, alpha, masking, true);
}

double quadrature_directional_albedo(double NoV, double alpha, Masking masking) {
    return settle(NoV, alpha, masking, false).E;
}

double quadrature_deficit(double NoV, double alpha, Masking masking) {
    return settle(NoV, alpha, masking, false).deficit;
}

double quadrature_average_deficit(double alpha, Masking masking) {
    if (alpha == 0) return 0;
    double lower = average_deficit_at(alpha, masking, kQuadratureOrders[0]);
    for (std::size_t step = 1;; ++step) {
        const double value = average_deficit_at(alpha, masking, kQuadratureOrders[step]);
        const bool agree = std::abs(value - lower) <= std::min(kAbsolute, 1e-6 * value);
        if (agree || step + 1 == std::size(kQuadratureOrders)) return value;
        lower = value;
    }
}

double quadrature_average_albedo(double alpha, Masking masking) {
    return 1 - quadrature_average_deficit(alpha, masking);
}

}  // namespace kiln
