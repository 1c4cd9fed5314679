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
constexpr std::size_t kStart = quadrature_start(1e-9);

const std::vector<double>& nodes_of(std::size_t step) {
    static const auto tables = [] {
        std::array<std::vector<double>, std::size(kQuadratureSteps)> all;
        std::transform(
            std::begin(kQuadratureSteps), std::end(kQuadratureSteps), all.begin(),
            [](const QuadratureStep& tried) { return quadrature_nodes({}, tried.order); });
        return all;
    }();
    return tables[step];
}

QuadratureValue at_order(double NoV, double alpha, Masking masking, bool fresnel,
                         std::size_t step) {
    const QuadratureOrder order = kQuadratureSteps[step].order;
    const Albedo albedo =
        quadrature(static_cast<int>(masking), fresnel ? KILN_FRESNEL_SCHLICK : KILN_FRESNEL_NONE,
                   nullptr, NoV, alpha, nodes_of(step).data(), order.elevation, order.azimuth);
    return {albedo.E, albedo.B, albedo.deficit, 0, 0, order};
}

QuadratureValue settle(double NoV, double alpha, Masking masking, bool fresnel) {
    QuadratureValue lower = at_order(NoV, alpha, masking, fresnel, kStart);
    for (std::size_t step = kStart + 1;; ++step) {
        QuadratureValue value = at_order(NoV, alpha, masking, fresnel, step);
        value.error = std::max(std::abs(value.E - lower.E), std::abs(value.B - lower.B));
        if (value.deficit > 0)
            value.deficit_error = std::abs(value.deficit - lower.deficit) / value.deficit;
        const bool agree = value.error <= kAbsolute && value.deficit_error <= kDeficitRelative;
        if (agree || step == kQuadratureLast) return value;
        lower = value;
    }
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

}  // namespace kiln
