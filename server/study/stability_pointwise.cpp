// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>

#include "server/study/stability.h"

// Values of one sample. Right is what the kernels' text gives in long double at the inputs as the
// format holds them, and stable is what is right, to some units of the last place, for inputs some
// units away (mixed forward and backward stability: Higham 2002, Accuracy and Stability of
// Numerical Algorithms, section 1.5). So a formula is not blamed for a model that amplifies its
// inputs, and no constant is fitted to what was seen.
namespace kiln::stability {

namespace {

/// Of points and alpha: rounded once on the host, and in each of a few operations that follow.
constexpr double kInputUnits = 4;
/// Parameters are rounded once, from double.
constexpr double kParameterUnits = 1;

/// The long doubles that a sample reads, as this format holds them; parameters as the host has
/// them.
WideInputs inputs_of(const Pointwise& p, const std::array<double, kPointScalars>& point,
                     const Place& place, const Format& format) {
    WideInputs at;
    at.NoV = format.rounded(place.NoV);
    at.alpha = format.rounded(place.alpha);
    for (std::size_t i = 0; i < kPointScalars; ++i) at.point[i] = format.rounded(point[i]);
    for (std::size_t i = 0; i < kParameterCount; ++i) at.parameters[i] = p.parameters[i];
    return at;
}

class Judge {
  public:
    Judge(const Pointwise& p, const KernelMaterial& material, const Format& format)
        : p_(p), material_(material), format_(format) {}

    Right operator()(std::size_t term, double scale, WideInputs at) {
        term_ = term;
        at_ = at;
        const long double value = wide_term(material_, term_, at_);
        value_ = value;
        spread_ = 0;
        pole_.reset();
        vary(at_.NoV, kInputUnits);
        vary(at_.alpha, kInputUnits);
        for (long double& number : at_.point) vary(number, kInputUnits);
        for (long double& number : at_.parameters) vary(number, kParameterUnits);
        const double there = held(static_cast<double>(value));
        if (std::isinf(there)) return {there, 0, {}};
        const double size = std::max(std::abs(there), scale);
        const double own = p_.forward_units * format_.unit * size;
        return {there, own + static_cast<double>(spread_) + format_.underflow, pole_};
    }

  private:
    /// What the format makes of a number beyond its range.
    double held(double value) const {
        const bool beyond = format_.single && std::abs(value) > 3.4028235e38;
        return beyond ? std::copysign(std::numeric_limits<double>::infinity(), value) : value;
    }

    /// The value's greatest change as one input moves, and the pole that it meets. 0 is exact, and
    /// so is 1.
    void vary(long double& input, double units) {
        const long double given = input;
        if (given == 0 || std::abs(given) == 1) return;
        long double most = 0;
        const auto tell = [&](long double moved) {
            input = moved;
            const long double there = wide_term(material_, term_, at_);
            if (std::isinf(there))
                pole_ = static_cast<double>(there);
            else if (!std::isnan(there))
                most = std::max(most, std::abs(there - value_));
            input = given;
        };
        // Of a subnormal number the last place is wider.
        const long double unit =
            std::max<long double>(format_.unit, format_.half_least / std::abs(given));
        tell(given * (1 - units * unit));
        tell(given * (1 + units * unit));
        // Where its square is no normal number, it may count as 0.
        if (std::abs(given) < format_.tiny) tell(0);
        spread_ += most;
    }

    const Pointwise& p_;
    KernelMaterial material_;
    Format format_;
    std::size_t term_ = 0;
    WideInputs at_;
    long double value_ = 0, spread_ = 0;
    std::optional<double> pole_;
};

}  // namespace

KernelMaterial material_of(const Pointwise& pointwise) {
    KernelMaterial material = pointwise.material;
    for (const Pointwise::Term& term : pointwise.terms) material.terms |= 1 << term.index;
    return material;
}

void run(Bench& bench, const Pointwise& p, Findings& findings) {
    const KernelMaterial material = material_of(p);
    // Terms that ride along have their sums, but no judge.
    std::vector<std::size_t> plane(kTermCount);
    std::size_t planes = 0;
    for (std::size_t t = 0; t < kTermCount; ++t)
        if (material.terms >> t & 1) plane[t] = planes++;
    std::vector<double> points;
    std::vector<BatchRange> batches;
    for (const auto& [name, point] : p.points) {
        batches.push_back({static_cast<unsigned>(batches.size()), 1});
        points.insert(points.end(), point.begin(), point.end());
    }
    const Bench::Sums sums = bench.run(material, p.parameters, points, batches, p.places);
    Judge single(p, material, kSingle), in_double(p, material, kDouble);
    const std::vector<Pointwise::Term>& terms = p.terms;
    for (std::size_t b = 0; b < p.points.size(); ++b) {
        bench.look();
        for (std::size_t t = 0; t < terms.size(); ++t)
            for (std::size_t i = 0; i < p.places.size(); ++i) {
                const Place& place = p.places[i];
                const std::string row =
                    p.rows_by_quantity ? p.model + ": " + terms[t].quantity : p.row;
                Finding found{p.family,
                              p.model,
                              row,
                              p.column(place),
                              terms[t].quantity,
                              p.points[b].first,
                              "the kernel in long double",
                              place.NoV,
                              place.alpha,
                              {},
                              {},
                              {},
                              terms[t].scale(place)};
                const auto& point = p.points[b].second;
                const std::size_t index = terms[t].index;
                found.in_float = single(index, found.scale, inputs_of(p, point, place, kSingle));
                found.in_double =
                    in_double(index, found.scale, inputs_of(p, point, place, kDouble));
                if (std::isnan(found.in_double.value)) continue;  // the model has no value there
                if (p.closed)
                    if (const auto known = p.closed(place)) {
                        found.in_float.value = found.in_double.value = *known;
                        found.source = p.closed_source;
                    }
                for (std::size_t a = 0; a < kArithmetics; ++a)
                    if (!sums[a].empty())
                        found.values[a] =
                            sums[a][(b * planes + plane[index]) * p.places.size() + i];
                found.limit = "rounding of its inputs and of some 30 steps";
                findings.add(std::move(found));
            }
    }
}

}  // namespace kiln::stability
