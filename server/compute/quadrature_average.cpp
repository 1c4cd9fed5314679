// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>

#include "server/compute/quadrature.h"

namespace kiln {

namespace {

/// What is asked of E, and of two orders of the average: a tenth of what is promised.
QuadratureTolerance tenth(double tolerance) {
    return {tolerance / 10, tolerance > 1e-9 ? 0 : 1e-7};
}

/// NoV and weight of 2 NoV dNoV. The cosine is alpha w (v^-8 - 1), as in kernels/ray.h, and v is
/// linear in the square of the node: 1 - E goes like NoV log NoV at the horizon, which the square
/// takes to the 12th order.
class AverageRule {
  public:
    explicit AverageRule(unsigned order) : order_(order), nodes_(gauss_legendre({order})) {}

    void append(double alpha, std::vector<double>& NoV, std::vector<double>& weights) const {
        const double width = std::min(0.7 * alpha, 0.5);
        const double slope = 1 / std::sqrt(std::sqrt(std::sqrt(1 + 1 / width))) - 1;
        for (std::size_t i = 0; i < order_; ++i) {
            const double u = nodes_[2 * i], v = 1 + slope * (u * u);
            const double v2 = v * v, v4 = v2 * v2, growth = 1 / (v4 * v4);
            const double cosine = std::min(1.0, width * (growth - 1));
            NoV.push_back(cosine);
            weights.push_back(nodes_[2 * i + 1] * 2 * cosine *
                              (-16 * width * slope * u * growth / v));
        }
    }
    std::size_t order() const { return order_; }

  private:
    std::size_t order_;
    std::vector<double> nodes_;
};

/// At one order of the rule and at the places named; the integrand's own is raised as it needs.
QuadratureAverages at_order(Backend& backend, const QuadratureKind& kind,
                            const QuadratureParameters& parameters, std::span<const double> alpha,
                            std::span<const std::size_t> places, const AverageRule& rule,
                            double tolerance) {
    const bool matte = kind.diffuse != kSpecular;
    std::vector<double> NoV, weights, alphas;
    for (const std::size_t place : places) {
        rule.append(matte ? 1 : alpha[place], NoV, weights);
        alphas.insert(alphas.end(), rule.order(), alpha[place]);
    }
    const QuadratureTolerance each =
        matte ? QuadratureTolerance{tolerance / 10, 0} : tenth(tolerance);
    const QuadratureResult found =
        integrate_quadrature(backend, kind, {NoV, alphas, parameters, {}}, each);
    const std::vector<double>& values = matte ? found.E : found.deficit;
    QuadratureAverages sums{{}, found.evaluations};
    for (std::size_t i = 0; i < weights.size(); i += rule.order())
        sums.mean.push_back(
            std::inner_product(weights.begin() + static_cast<std::ptrdiff_t>(i),
                               weights.begin() + static_cast<std::ptrdiff_t>(i + rule.order()),
                               values.begin() + static_cast<std::ptrdiff_t>(i), 0.0));
    return sums;
}

}  // namespace

QuadratureKind quadrature_average_kind(Masking masking) {
    return {masking, kNoFresnel, Precision::float64, kSpecular};
}

QuadratureAverages quadrature_averages(Backend& backend, const QuadratureKind& kind,
                                       const QuadratureParameters& parameters,
                                       std::span<const double> alpha, double tolerance,
                                       const std::function<void()>& between) {
    constexpr std::size_t kPlacesALaunch = 256;
    QuadratureAverages result{std::vector<double>(alpha.size(), 0.0), 0};
    std::vector<std::size_t> left;
    const std::size_t start = quadrature_start(std::max(tolerance, 1e-6));
    for (std::size_t i = 0; i < alpha.size(); ++i)
        if (alpha[i] > 0 || kind.diffuse != kSpecular) left.push_back(i);
    for (std::size_t step = start; step <= kQuadratureLast && !left.empty(); ++step) {
        const AverageRule rule(kQuadratureSteps[step].order.elevation);
        std::vector<std::size_t> unsettled;
        for (std::size_t first = 0; first < left.size(); first += kPlacesALaunch) {
            const auto places =
                std::span(left).subspan(first, std::min(kPlacesALaunch, left.size() - first));
            const QuadratureAverages sums =
                at_order(backend, kind, parameters, alpha, places, rule, tolerance);
            result.evaluations += sums.evaluations;
            for (std::size_t i = 0; i < places.size(); ++i) {
                double& value = result.mean[places[i]];
                const double next = sums.mean[i];
                const bool agree =
                    std::abs(next - value) <=
                    (tolerance > 1e-9 ? tolerance / 10 : std::min(1e-10, 1e-6 * next));
                value = next;
                if (step == start || !agree) unsettled.push_back(places[i]);
            }
            between();
        }
        left = std::move(unsettled);
    }
    return result;
}

}  // namespace kiln
