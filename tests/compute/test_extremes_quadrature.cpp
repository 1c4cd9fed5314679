// SPDX-License-Identifier: Apache-2.0
// Random extreme inputs through the quadrature: nothing that is not finite, nothing outside its
// proven range, and of a part the same bits from OpenCL.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <string>
#include <variant>
#include <vector>

#include "server/compute/plan.h"
#include "server/compute/quadrature.h"
#include "server/compute/quadrature_integrals.h"
#include "server/spec/words.h"
#include "tests/compute/every_lobe.h"
#include "tests/compute/extremes.h"

namespace kiln {
namespace {

using namespace extremes;

/// An integral of a job that the contract takes, whose numbers are as extreme as it lets them be.
Integral any_integral(Draw& draw, Precision precision) {
    static const std::vector<JobSpec> lobes = every_lobe_job();
    JobSpec job = lobes[draw.below(lobes.size())];
    if (draw.below(3) == 0) job = lobes.front();  // GGX under Smith's masking
    job.integrator = Integrator::quadrature;
    job.precision = precision;
    job.fresnel = any_fresnel(draw);
    job.diffuse.model = static_cast<DiffuseModel>(1 + draw.below(KILN_DIFFUSE_COUNT));
    job.diffuse.albedo = {draw.zero_to_one()};
    job.coupling = Coupling::half_vector;
    constexpr Quantity kQuantities[] = {Quantity::directional_albedo, Quantity::split_sum_bias,
                                        Quantity::specular_albedo, Quantity::diffuse_albedo,
                                        Quantity::total_albedo};
    job.quantities = {kQuantities[draw.below(std::size(kQuantities))]};
    if (quadrature_lacks(job, job.quantities[0])) return any_integral(draw, precision);
    std::vector<Integral> all;
    for (const Pass& pass : make_plan(job, [] { return Averages{}; }).passes) {
        if (walks(pass)) continue;
        for (const Integral& integral : integrals_of(job, pass)) all.push_back(integral);
    }
    return all.empty() ? any_integral(draw, precision) : all[draw.below(all.size())];
}

std::string name_of(const Integral& integral, std::size_t step) {
    const QuadratureKind& kind = integral.kind;
    std::string name(to_word(kind.precision));
    name += ", step " + std::to_string(step);
    if (const auto* smith = std::get_if<SmithRule>(&kind.rule))
        name += ", masking " + std::to_string(static_cast<int>(smith->masking));
    if (const auto* lobe = std::get_if<LobeRule>(&kind.rule))
        name += ", distribution " + std::to_string(lobe->distribution) + ", masking " +
                std::to_string(lobe->masking) + ", total " + std::to_string(lobe->total_reflection);
    if (const auto* matte = std::get_if<DiffuseRule>(&kind.rule))
        name += ", diffuse " + std::to_string(matte->diffuse);
    name += ", Fresnel " + std::to_string(fresnel_of(kind)) + ", parameters";
    for (const double parameter : integral.parameters) name += ' ' + std::to_string(parameter);
    return name;
}

/// As many places as make a launch cost some milliseconds, a multiple of kLanesMax.
std::size_t places_of(const QuadratureKind& kind, QuadratureOrder order) {
    constexpr std::uint64_t kEvaluations = 500000;
    const std::uint64_t places = kEvaluations / quadrature_evaluations(kind, order);
    return std::clamp<std::size_t>(places / kLanesMax, 1, 32) * kLanesMax;
}

/// One launch with what it points to.
template <typename Scalar>
struct Extreme {
    Integral integral;
    std::size_t step, stride;
    std::vector<Scalar> parameters, texels, nodes, values;

    Extreme(Draw& draw, const Integral& what)
        : integral(what),
          step(draw.below(std::size(kQuadratureSteps))),
          stride(places_of(what.kind, kQuadratureSteps[step].order)),
          parameters(what.parameters.begin(), what.parameters.end()),
          texels(2 * stride),
          values(quadrature_planes(what.kind) * stride) {
        const auto rule = quadrature_nodes(what.kind, kQuadratureSteps[step].order);
        nodes.assign(rule.begin(), rule.end());
        // Charlie's E has no bound where NoV vanishes.
        const auto* lobe = std::get_if<LobeRule>(&what.kind.rule);
        const bool cloth = lobe && lobe->distribution == KILN_DISTRIBUTION_CHARLIE;
        for (std::size_t i = 0; i < stride; ++i) {
            texels[i] = static_cast<Scalar>(cloth ? draw.log(1e-17, 1) : draw.zero_to_one());
            texels[stride + i] = static_cast<Scalar>(draw.zero_to_one());
        }
    }

    QuadratureLaunch<Scalar> launch() {
        return {integral.kind, stride, texels, nodes, parameters, kQuadratureSteps[step].order,
                values};
    }
};

struct Range {
    double lo, hi;
};

/// F in [0, 1], but for Hoffman's tint: fresnel.h.
double least_of_fresnel(const QuadratureKind& kind) {
    constexpr int kTint82 = 5;
    return fresnel_of(kind) == kTint82 ? -0.13 : 0;
}

/// Every node and every weight of a rule is positive, so that nothing that is not negative becomes
/// so at any order.
Range range_of_albedo(const QuadratureKind& kind) {
    const double infinite = std::numeric_limits<double>::max();
    if (const auto* matte = std::get_if<DiffuseRule>(&kind.rule)) {
        const bool conserves = matte->diffuse == KILN_DIFFUSE_LAMBERT ||
                               matte->diffuse == KILN_DIFFUSE_FON ||
                               matte->diffuse == KILN_DIFFUSE_EON;
        return {0, conserves ? 1 - least_of_fresnel(kind) : infinite};
    }
    return {0, integrates_deficit(kind) ? 1 : infinite};
}

/// How far B may leave its range, as part of max(1, E). Under total reflection E − B is found by a
/// rule of its own, and two rules are as far apart as both are off: the tables of quadrature.h,
/// where Charlie's begins at order 16.
double apart(const QuadratureKind& kind, std::size_t step) {
    const auto* lobe = std::get_if<LobeRule>(&kind.rule);
    if (!lobe || !lobe->total_reflection) return 0;
    const std::size_t later = lobe->distribution == KILN_DISTRIBUTION_CHARLIE ? 6 : 0;
    return step < later ? 1 : kQuadratureSteps[step - later].error;
}

/// Whether the values of a place are what theory lets them be. B is E times a mean of F.
template <typename Scalar>
bool in_range(const Extreme<Scalar>& extreme, std::size_t place) {
    const QuadratureKind& kind = extreme.integral.kind;
    const bool narrow = sizeof(Scalar) == sizeof(float);
    const double E = extreme.values[place];
    const double unit = std::max(1.0, E), step_error = kQuadratureSteps[extreme.step].error;
    const double rounding = (narrow ? quadrature_float_rounding(kind) : 1e-14) * unit;
    const auto lies = [](double value, Range in, double within) {
        return value >= in.lo - within && value <= in.hi + within;
    };
    const Range range = range_of_albedo(kind);
    if (is_diffuse(kind)) return lies(E, range, step_error + rounding);
    const double deficit = extreme.values[extreme.stride + place];
    if (!lies(E, range, 0) || !lies(deficit, {1 - range.hi, 1}, 0)) return false;
    if (fresnel_of(kind) == kNoFresnel) return true;
    return lies(extreme.values[2 * extreme.stride + place], {least_of_fresnel(kind) * E, E},
                apart(kind, extreme.step) * unit + rounding);
}

template <typename Scalar>
void hold_ranges(const Extreme<Scalar>& extreme) {
    for (std::size_t i = 0; i < extreme.stride; ++i) {
        if (in_range(extreme, i)) continue;
        std::string values;
        for (std::size_t at = i; at < extreme.values.size(); at += extreme.stride)
            values += std::to_string(extreme.values[at]) + ' ';
        ADD_FAILURE() << values << "at NoV " << extreme.texels[i] << " alpha "
                      << extreme.texels[extreme.stride + i] << ", "
                      << name_of(extreme.integral, extreme.step);
        return;
    }
}

Integral any_integral(Draw& draw) {
    return any_integral(draw, static_cast<Precision>(draw.below(2)));
}

class QuadratureExtremes : public OnNative {
  protected:
    template <typename Scalar>
    std::size_t check(Draw& draw, const Integral& what) {
        Extreme<Scalar> extreme(draw, what);
        native_->run(extreme.launch());
        hold_ranges(extreme);
        return extreme.stride;
    }
};

// At all orders, a quarter as many as the sampling kernels take: 250 000 a run, in two seconds.
TEST_F(QuadratureExtremes, StayFiniteAndInRange) {
    Draw draw(20262);
    for (std::size_t done = 0; done < input_count() / 4 && !HasFailure();) {
        const Integral what = any_integral(draw);
        done += what.kind.precision == Precision::float32 ? check<float>(draw, what)
                                                          : check<double>(draw, what);
    }
}

class QuadratureExtremesOnOpenCl : public OnBoth {
  protected:
    /// A kind is a program, which takes most of a second to compile: a few of each rule.
    Integral compiled_integral(Draw& draw) {
        for (;;) {
            const Integral what = any_integral(draw);
            std::set<QuadratureKind>& kinds = kinds_[what.kind.rule.index()];
            if (kinds.size() < kKinds) kinds.insert(what.kind);
            if (kinds.contains(what.kind)) return what;
        }
    }

    template <typename Scalar>
    std::size_t check(Draw& draw, const Integral& what) {
        Extreme<Scalar> extreme(draw, what);
        EXPECT_TRUE(have_equal_bits(extreme.launch(), extreme.values))
            << name_of(what, extreme.step);
        return extreme.stride;
    }

  private:
    static constexpr std::size_t kKinds = 4;
    std::array<std::set<QuadratureKind>, 3> kinds_;
};

// 62 500 a run.
TEST_F(QuadratureExtremesOnOpenCl, HaveTheSameBits) {
    Draw draw(20263);
    for (std::size_t done = 0; done < input_count() / 16 && !HasFailure();) {
        const Integral what = compiled_integral(draw);
        done += what.kind.precision == Precision::float32 ? check<float>(draw, what)
                                                          : check<double>(draw, what);
    }
}

}  // namespace
}  // namespace kiln
