// SPDX-License-Identifier: Apache-2.0
#include "server/compute/fresnel.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>

#include "server/base/error.h"
#include "server/compute/one_lane.h"
#include "server/spec/metals.h"

namespace kiln {
namespace {

namespace kernels = one_lane;

static_assert(kFresnelParameters == KILN_FRESNEL_PARAMETERS);

std::string plain(double value) {
    std::string text = std::to_string(value);
    text.erase(std::max(text.find_last_not_of('0') + 1, text.find('.') + 2));
    return text;
}

/// A parameter of the model for one channel, checked.
class Reader {
  public:
    explicit Reader(int channel) : channel_(static_cast<std::size_t>(channel)) {
        if (channel < 0 || channel > 2)
            throw Error("fresnel_range", "a Fresnel model has the channels 0, 1 and 2");
    }

    double operator()(const char* name, const std::vector<double>& values, double lo,
                      double hi) const {
        if (values.size() != 1 && values.size() != 3)
            throw Error("fresnel_range", std::string("the Fresnel parameter ") + name +
                                             " must have 1 value or 3, it has " +
                                             std::to_string(values.size()));
        return within(name, values[values.size() == 1 ? 0 : channel_], lo, hi);
    }

    static double within(const char* name, double value, double lo, double hi) {
        if (value >= lo && value <= hi) return value;  // false for NaN
        throw Error("fresnel_range", std::string("the Fresnel parameter ") + name + " is " +
                                         plain(value) + ", it must lie in [" + plain(lo) + ", " +
                                         plain(hi) + "]");
    }

  private:
    std::size_t channel_;
};

IndexPair conductor_pair(const FresnelModel& model, const Reader& read) {
    constexpr double most = FresnelLimits::index_max;
    if (model.model == Fresnel::edge_tint)
        return index_from_edge_tint(
            read("reflectivity", model.reflectivity, 0, FresnelLimits::reflectivity_max),
            read("edge_tint", model.edge_tint, 0, 1));
    const auto values = [](const std::array<double, 3>& of) {
        return std::vector<double>(of.begin(), of.end());
    };
    IndexPair pair{};
    if (model.metal) {
        const MetalConstants& metal = metal_constants(*model.metal);
        pair = {read("eta", values(metal.eta), 0, most), read("k", values(metal.k), 0, most)};
    } else {
        pair = {read("eta", model.eta, 0, most), read("k", model.k, 0, most)};
    }
    Reader::within("max(eta, k)", std::max(pair.eta, pair.k), FresnelLimits::index_min, most);
    return pair;
}

double schlick_exponent(const FresnelModel& model) {
    if (!(model.exponent > 0))
        throw Error("fresnel_range", "the Fresnel parameter exponent must be above 0");
    return Reader::within("exponent", model.exponent, 0, FresnelLimits::exponent_max);
}

/// Factor of VoH (1 − VoH)^6 in the F82 tint; that term is largest at VoH = 1/7.
double f82_bend(double f0, double f82) {
    const double schlick = f0 + (1 - f0) * std::pow(6.0 / 7, 5);
    return schlick * (1 - f82) / (std::pow(6.0 / 7, 6) / 7);
}

}  // namespace

int fresnel_function(const FresnelModel& model) {
    switch (model.model) {
        case Fresnel::none:
            return KILN_FRESNEL_NONE;
        case Fresnel::schlick:
            return model.exponent == 5 ? KILN_FRESNEL_SCHLICK : KILN_FRESNEL_SCHLICK_POWER;
        case Fresnel::dielectric:
            return KILN_FRESNEL_DIELECTRIC;
        case Fresnel::conductor:
        case Fresnel::edge_tint:
            return KILN_FRESNEL_CONDUCTOR;
        case Fresnel::f82_tint:
            return KILN_FRESNEL_F82_TINT;
    }
    __builtin_unreachable();
}

std::array<double, kFresnelParameters> fresnel_parameters(const FresnelModel& model, int channel) {
    const Reader read(channel);
    switch (model.model) {
        case Fresnel::none:
            return {};
        case Fresnel::schlick: {
            const double f0 = read("f0", model.f0, 0, 1);
            return {f0, read("f90", model.f90, 0, 1) - f0, schlick_exponent(model)};
        }
        case Fresnel::dielectric: {
            const double n = read("ior", model.ior, FresnelLimits::ior_min, FresnelLimits::ior_max);
            return {(n - 1) * (n + 1), n * n, n == 1 ? 0.0 : 1.0};
        }
        case Fresnel::conductor:
        case Fresnel::edge_tint: {
            const auto [n, k] = conductor_pair(model, read);
            const double contrast = (n - 1) * (n + 1) - k * k;
            const double loss = 2 * n * k;
            return {contrast, (n - k) * (n + k), loss, std::hypot(contrast, loss)};
        }
        case Fresnel::f82_tint: {
            const double f0 = read("f0", model.f0, 0, 1);
            return {f0, 1 - f0, -f82_bend(f0, read("f82", model.f82, 0, 1))};
        }
    }
    __builtin_unreachable();
}

double fresnel(const FresnelModel& model, int channel, double VoH) {
    return kernels::fresnel(fresnel_function(model), fresnel_parameters(model, channel).data(),
                            VoH);
}

// With s = √reflectivity the textbook forms are eta = mix(eta_max, eta_min, g), eta_max = (1 + s) /
// (1 − s), eta_min = (1 − s²) / (1 + s²), and k² = ((eta + 1)² s² − (eta − 1)²) / (1 − s²), of
// which the difference of squares is taken apart: k = 0 at g = 0, and nothing cancels near it.
IndexPair index_from_edge_tint(double reflectivity, double edge_tint) {
    Reader::within("reflectivity", reflectivity, 0, FresnelLimits::reflectivity_max);
    Reader::within("edge_tint", edge_tint, 0, 1);
    const double s = std::sqrt(reflectivity);
    const double most = (1 + s) / (1 - s);
    const double least = (1 - s) * (1 + s) / (1 + reflectivity);
    const double eta = (1 - edge_tint) * most + edge_tint * least;
    const double k2 =
        (eta * (1 + s) - (1 - s)) * 2 * s * edge_tint / ((1 - s) * (1 + reflectivity));
    return {eta, std::sqrt(k2)};
}

// F ≥ 0 where b ≤ (F0 m^-5 + 1 − F0) / (m (1 − m)) at every m; the right side is convex.
double f82_least(double f0) {
    Reader::within("f0", f0, 0, 1);
    const auto bend_most = [f0](double m) {
        return (f0 * std::pow(m, -5) + 1 - f0) / (m * (1 - m));
    };
    double lo = 0.5, hi = 6.0 / 7;  // the least of either addend, of F0 = 0 and F0 = 1
    for (int step = 0; step < 100; ++step) {
        const double third = (hi - lo) / 3;
        if (bend_most(lo + third) < bend_most(hi - third))
            hi -= third;
        else
            lo += third;
    }
    return std::max(0.0, 1 - bend_most(lo) / f82_bend(f0, 0));
}

std::optional<Excursion> fresnel_excursion(const FresnelModel& model, int channel) {
    if (model.model != Fresnel::f82_tint) return std::nullopt;
    const Reader read(channel);
    if (read("f82", model.f82, 0, 1) >= f82_least(read("f0", model.f0, 0, 1))) return std::nullopt;
    constexpr int kSteps = 1000;
    Excursion found{0, 0, 1, 0};
    for (int i = 0; i <= kSteps; ++i) {
        const double VoH = static_cast<double>(i) / kSteps, F = fresnel(model, channel, VoH);
        if (F >= 0) continue;
        found.begin = std::min(found.begin, VoH);
        found.end = VoH;
        if (F < found.least) found.least = F, found.at = VoH;
    }
    if (found.least < 0) return found;
    return std::nullopt;
}

}  // namespace kiln
