// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>

#include "server/compute/quadrature.h"
#include "server/compute/terms.h"

namespace kiln {

namespace {

/// What is asked of E, and of two orders of the average: a tenth of what is promised.
QuadratureTolerance tenth(double tolerance) {
    return {tolerance / 10, tolerance > 1e-9 ? 0 : 1e-7};
}

/// Two orders agree within this part of the tolerance. E of lobes whose masking is none of Smith's
/// costs a hundred times what theirs does, and the higher order is the better one anyway.
double share_of(const QuadratureKind& kind) {
    return std::holds_alternative<LobeRule>(kind.rule) ? 1 : 0.1;
}

/// NoV from one end to the other; the nodes are dense at `from`, from the distance `width` on.
struct AveragePiece {
    double from = 0, to = 1, width = 0.5;
};

/// Maskings of Charlie's go like powers of 0.17 to 0.2 at both ends, and two fits meet at 1/2.
std::vector<AveragePiece> pieces_of(const QuadratureKind& kind, double alpha) {
    constexpr double kTip = 1e-6;  // what is missed is below its square, and w^1.17 at the zenith
    if (is_diffuse(kind)) return {{0, 1, 0.5}};
    const auto* lobe = std::get_if<LobeRule>(&kind.rule);
    if (lobe && is_charlie_fit(lobe->masking)) return {{0, 0.5, kTip}, {1, 0.5, kTip}};
    if (!(alpha > 0)) return {{0, 1, 0.5}};
    if (lobe && lobe->distribution == static_cast<int>(Distribution::charlie))
        return {{0, 1, 0.5 * std::sqrt(alpha)}};
    return {{0, 1, std::min(0.7 * alpha, 0.5)}};
}

/// NoV and weight of 2 NoV dNoV. The distance from a piece's start is width (v^-8 - 1), as in
/// kernels/ray.h, and v is linear in the square of the node: 1 - E goes like NoV log NoV at the
/// horizon, which the square takes to the 12th order.
class AverageRule {
  public:
    explicit AverageRule(unsigned order) : order_(order), nodes_(gauss_legendre({order})) {}

    void append(const std::vector<AveragePiece>& pieces, std::vector<double>& NoV,
                std::vector<double>& weights) const {
        for (const AveragePiece& piece : pieces) append(piece, NoV, weights);
    }

  private:
    void append(const AveragePiece& piece, std::vector<double>& NoV,
                std::vector<double>& weights) const {
        const double length = std::abs(piece.to - piece.from);
        const double side = piece.to > piece.from ? 1 : -1;
        const double slope = 1 / std::sqrt(std::sqrt(std::sqrt(1 + length / piece.width))) - 1;
        for (std::size_t i = 0; i < order_; ++i) {
            const double u = nodes_[2 * i], v = 1 + slope * (u * u);
            const double v2 = v * v, v4 = v2 * v2, growth = 1 / (v4 * v4);
            const double cosine = std::min(1.0, piece.from + side * (piece.width * (growth - 1)));
            NoV.push_back(cosine);
            weights.push_back(nodes_[2 * i + 1] * 2 * cosine *
                              (-16 * piece.width * slope * u * growth / v));
        }
    }

    std::size_t order_;
    std::vector<double> nodes_;
};

/// At one order of the rule and at the places named; the integrand's own is raised as it needs.
QuadratureAverages at_order(Backend& backend, const QuadratureKind& kind,
                            const QuadratureParameters& parameters, std::span<const double> alpha,
                            std::span<const std::size_t> places, const AverageRule& rule,
                            double tolerance) {
    const bool matte = is_diffuse(kind);
    std::vector<double> NoV, weights, alphas;
    for (const std::size_t place : places) {
        rule.append(pieces_of(kind, alpha[place]), NoV, weights);
        alphas.resize(NoV.size(), alpha[place]);
    }
    const std::size_t nodes = weights.size() / places.size();
    const QuadratureTolerance each = integrates_deficit(kind)
                                         ? tenth(tolerance)
                                         : QuadratureTolerance{tolerance * share_of(kind) / 4, 0};
    const QuadratureResult found =
        integrate_quadrature(backend, kind, {NoV, alphas, parameters, {}}, each);
    const std::vector<double>& values = matte ? found.E : found.deficit;
    QuadratureAverages sums{{}, found.evaluations};
    for (std::size_t i = 0; i < weights.size(); i += nodes)
        sums.mean.push_back(
            std::inner_product(weights.begin() + static_cast<std::ptrdiff_t>(i),
                               weights.begin() + static_cast<std::ptrdiff_t>(i + nodes),
                               values.begin() + static_cast<std::ptrdiff_t>(i), 0.0));
    return sums;
}

}  // namespace

QuadratureKind quadrature_average_kind(const KernelMaterial& lobe) {
    return quadrature_kind(lobe, kNoFresnel, {}, Precision::float64);
}

QuadratureAverages quadrature_averages(Backend& backend, const QuadratureKind& kind,
                                       const QuadratureParameters& parameters,
                                       std::span<const double> alpha, double tolerance,
                                       const std::function<void()>& between) {
    constexpr std::size_t kPlacesALaunch = 256;
    QuadratureAverages result{std::vector<double>(alpha.size(), 0.0), 0};
    std::vector<std::size_t> left;
    const bool relative = tolerance <= 1e-9 && integrates_deficit(kind);
    const std::size_t start = quadrature_start(kind, std::max(tolerance, 1e-6));
    for (std::size_t i = 0; i < alpha.size(); ++i)
        if (alpha[i] > 0 || !integrates_deficit(kind)) left.push_back(i);
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
                const bool agree = std::abs(next - value) <=
                                   (relative ? std::min(1e-10, 1e-6 * std::max(next, kDeficitLeast))
                                             : tolerance * share_of(kind));
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
