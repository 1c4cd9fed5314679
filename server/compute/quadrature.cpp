// SPDX-License-Identifier: Apache-2.0
#include "server/compute/quadrature.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "server/base/error.h"
#include "server/compute/non_finite.h"
#include "server/compute/terms.h"

namespace kiln {

namespace {

/// Value and derivative of the Legendre polynomial of the given degree, |x| < 1.
std::pair<double, double> legendre(unsigned degree, double x) {
    double before = 1, value = x;
    for (unsigned k = 2; k <= degree; ++k) {
        const double next = ((2 * k - 1) * x * value - (k - 1) * before) / k;
        before = value;
        value = next;
    }
    return {value, degree * (before - x * value) / ((1 - x) * (1 + x))};
}

/// Appends the rule of `count` nodes on [0, 1].
void append_rule(unsigned count, std::vector<double>& out) {
    const std::size_t first = out.size();
    out.resize(first + 2 * count);
    for (unsigned i = 0; i < (count + 1) / 2; ++i) {
        // Tricomi's first guess, exact for the middle node; Newton's method doubles its digits.
        double x = 2 * i + 1 == count ? 0 : cos_turn((i + 0.75) / (2 * count + 1));
        for (int step = 0; step < 5; ++step) {
            const auto [value, slope] = legendre(count, x);
            x -= value / slope;
        }
        const double slope = legendre(count, x).second;
        const double weight = 1 / ((1 - x) * (1 + x) * slope * slope);
        out[first + 2 * i] = 0.5 * (1 - x);
        out[first + 2 * (count - 1 - i)] = 0.5 * (1 + x);
        out[first + 2 * i + 1] = out[first + 2 * (count - 1 - i) + 1] = weight;
    }
}

/// The texels that are still worked on, packed into one launch after another.
template <typename Scalar>
class Raising {
  public:
    Raising(Backend& backend, const QuadratureKind& kind, const QuadraturePlaces& places,
            const QuadratureTolerance& tolerance)
        : backend_(backend),
          kind_(kind),
          NoV_(places.NoV),
          alpha_(places.alpha),
          parameters_(places.parameters.begin(), places.parameters.end()),
          steps_(places.steps),
          tolerance_(tolerance) {
        if constexpr (sizeof(Scalar) == sizeof(float)) {
            tolerance_.absolute =
                std::max(tolerance_.absolute, quadrature_float_rounding(kind) / 2);
            if (tolerance_.deficit_relative > 0)
                tolerance_.deficit_relative =
                    std::max(tolerance_.deficit_relative, kQuadratureFloatRounding / 2);
        }
        const float unknown = std::numeric_limits<float>::infinity();
        result_.E.resize(NoV_.size());
        result_.deficit.resize(NoV_.size());
        result_.step.resize(NoV_.size());
        result_.error.assign(NoV_.size(), unknown);
        result_.deficit_error.assign(NoV_.size(), unknown);
        if (has_B()) result_.B.resize(NoV_.size());
    }

    QuadratureResult run() {
        if (!steps_.empty()) {
            std::array<std::vector<std::size_t>, kQuadratureLast + 1> texels;
            for (std::size_t i = 0; i < steps_.size(); ++i) texels[steps_[i]].push_back(i);
            for (std::size_t step = 0; step <= kQuadratureLast; ++step)
                at_step(step, texels[step], false);
            return std::move(result_);
        }
        double finest = tolerance_.absolute;
        if (tolerance_.deficit_relative > 0) finest = std::min(finest, tolerance_.deficit_relative);
        std::array<std::vector<std::size_t>, kQuadratureLast + 1> begin;
        for (std::size_t i = 0; i < NoV_.size(); ++i)
            begin[quadrature_start(kind_, finest, NoV_[i])].push_back(i);
        std::vector<std::size_t> texels;
        for (std::size_t step = 0; step <= kQuadratureLast; ++step) {
            texels = at_step(step, texels, true);
            at_step(step, begin[step], false);
            texels.insert(texels.end(), begin[step].begin(), begin[step].end());
        }
        result_.unsettled = texels.size();
        return std::move(result_);
    }

  private:
    /// The texels that do not agree with their last order.
    std::vector<std::size_t> at_step(std::size_t step, std::span<const std::size_t> texels,
                                     bool compare) {
        if (texels.empty()) return {};
        step_ = static_cast<std::uint8_t>(step);
        order_ = kQuadratureSteps[step].order;
        const std::vector<double> nodes = quadrature_nodes(kind_, order_);
        nodes_.assign(nodes.begin(), nodes.end());
        std::vector<std::size_t> left;
        for (std::size_t first = 0; first < texels.size(); first += backend_.block_places()) {
            const std::size_t count = std::min(backend_.block_places(), texels.size() - first);
            block(texels.subspan(first, count), compare, left);
        }
        result_.evaluations += texels.size() * quadrature_evaluations(kind_, order_);
        result_.order_max = order_;
        return left;
    }

    /// One launch; texels that do not agree with their last order go to `left`.
    void block(std::span<const std::size_t> places, bool compare, std::vector<std::size_t>& left) {
        const std::size_t stride = (places.size() + kLanesMax - 1) / kLanesMax * kLanesMax;
        texels_.resize(2 * stride);
        const std::size_t planes = quadrature_planes(kind_);
        values_.resize(planes * stride);
        for (std::size_t i = 0; i < stride; ++i) {
            const std::size_t place = places[std::min(i, places.size() - 1)];
            texels_[i] = static_cast<Scalar>(NoV_[place]);
            texels_[stride + i] = static_cast<Scalar>(alpha_[place]);
        }
        backend_.run(
            QuadratureLaunch<Scalar>{kind_, stride, texels_, nodes_, parameters_, order_, values_});
        for (std::size_t i = 0; i < places.size(); ++i) {
            const double E = values_[i], deficit = planes > 1 ? values_[stride + i] : Scalar(0);
            const double B = planes > 2 ? values_[2 * stride + i] : Scalar(0);
            const auto* lobe = std::get_if<LobeRule>(&kind_.rule);
            if (!std::isfinite(E) || !std::isfinite(B) || !std::isfinite(deficit))
                throw non_finite("a value of the table, by quadrature, is",
                                 lobe ? lobe->distribution : 0);
            const std::size_t place = places[i];
            if (compare) note_error(place, E, B, deficit);
            result_.E[place] = E;
            result_.deficit[place] = deficit;
            result_.step[place] = step_;
            if (has_B()) result_.B[place] = B;
            if (!agrees(place)) left.push_back(place);
        }
    }

    void note_error(std::size_t place, double E, double B, double deficit) {
        double difference = std::abs(E - result_.E[place]);
        if (has_B()) difference = std::max(difference, std::abs(B - result_.B[place]));
        result_.error[place] = static_cast<float>(difference);
        const double change = std::abs(deficit - result_.deficit[place]);
        result_.deficit_error[place] = static_cast<float>(
            change > 0 ? change / std::max({deficit, change, kDeficitLeast}) : 0);
    }

    bool has_B() const { return quadrature_planes(kind_) > 2; }

    bool agrees(std::size_t place) const {
        return result_.error[place] <= tolerance_.absolute * std::max(1.0, result_.E[place]) &&
               (tolerance_.deficit_relative <= 0 ||
                result_.deficit_error[place] <= tolerance_.deficit_relative);
    }

    Backend& backend_;
    QuadratureKind kind_;
    std::span<const double> NoV_, alpha_;
    std::vector<Scalar> parameters_;
    std::span<const std::uint8_t> steps_;
    std::uint8_t step_ = 0;
    QuadratureTolerance tolerance_;
    QuadratureResult result_;
    QuadratureOrder order_;
    std::vector<Scalar> nodes_, texels_, values_;
};

}  // namespace

std::vector<double> gauss_legendre(std::initializer_list<unsigned> counts) {
    std::vector<double> nodes;
    for (const unsigned count : counts) append_rule(count, nodes);
    return nodes;
}

std::uint64_t quadrature_evaluations(const QuadratureKind& kind, QuadratureOrder order) {
    const std::uint64_t n = order.elevation, m = order.azimuth;
    const bool fresnel = fresnel_of(kind) != kNoFresnel;
    if (is_diffuse(kind)) return 2 * n * 2 * m;  // two pieces of both
    const auto* lobe = std::get_if<LobeRule>(&kind.rule);
    if (!lobe) return (2 * n + n / 2) * (fresnel ? 1 + m : 1) + n / 2;
    // As make_cuts() of kernels/elevation.h has it: two pieces between two cuts.
    const bool ggx = lobe->distribution == static_cast<int>(Distribution::ggx);
    const bool charlie_masking = is_charlie_fit(lobe->masking);
    const std::uint64_t cuts =
        3U + (charlie_masking ? 1U : 0U) + (lobe->total_reflection ? 2U : 0U);
    const std::uint64_t rings = (ggx && !fresnel ? 0U : 1U) + (lobe->total_reflection ? 1U : 0U);
    return 2 * (cuts - 1) * n * std::max<std::uint64_t>(1, rings * m) +
           (integrates_deficit(kind) ? n * (ggx ? 1 : m) : 0);
}

double quadrature_float_rounding(const QuadratureKind& kind) {
    const auto* lobe = std::get_if<LobeRule>(&kind.rule);
    const bool charlie = lobe && is_charlie_fit(lobe->masking);
    return charlie ? 3.5 * kQuadratureFloatRounding : kQuadratureFloatRounding;
}

bool integrates_deficit(const QuadratureKind& kind) {
    if (const auto* lobe = std::get_if<LobeRule>(&kind.rule))
        return lobe->masking <= static_cast<int>(Masking::smith_separable);
    return !is_diffuse(kind);
}

QuadratureParameters any_quadrature_parameters(const QuadratureKind& kind) {
    const auto* lobe = std::get_if<LobeRule>(&kind.rule);
    if (lobe && lobe->total_reflection) return {-0.75, 0.25, 1};  // of an ior of 1/2
    const auto any = any_parameters<double>();
    QuadratureParameters parameters;
    std::copy_n(any.begin(), parameters.size(), parameters.begin());
    return parameters;
}

QuadratureKind quadrature_kind(const KernelMaterial& lobe, int fresnel,
                               const QuadratureParameters& parameters, Precision precision) {
    FresnelModel dielectric;
    dielectric.model = Fresnel::dielectric;
    const bool total = fresnel == fresnel_function(dielectric) && parameters[0] < 0;
    const bool smith = lobe.distribution == static_cast<int>(Distribution::ggx) &&
                       lobe.masking <= static_cast<int>(Masking::smith_separable);
    if (smith && !total) return {SmithRule{static_cast<Masking>(lobe.masking), fresnel}, precision};
    return {LobeRule{lobe.distribution, lobe.masking, fresnel, total}, precision};
}

std::vector<double> quadrature_nodes(const QuadratureKind& kind, QuadratureOrder order) {
    const unsigned n = order.elevation;
    if (std::holds_alternative<SmithRule>(kind.rule))
        return gauss_legendre({n, n / 2, order.azimuth});
    std::vector<double> nodes = gauss_legendre({n, order.azimuth});
    if (!is_diffuse(kind)) return nodes;
    for (std::size_t i = 2 * n; i < nodes.size(); i += 2) {
        nodes[i] = cos_turn(nodes[i] / 4);
        nodes[i + 1] /= 2;
    }
    return nodes;
}

QuadratureResult integrate_quadrature(Backend& backend, const QuadratureKind& kind,
                                      const QuadraturePlaces& places,
                                      const QuadratureTolerance& tolerance) {
    if (kind.precision == Precision::float64)
        return Raising<double>(backend, kind, places, tolerance).run();
    return Raising<float>(backend, kind, places, tolerance).run();
}

}  // namespace kiln
