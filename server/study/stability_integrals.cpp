// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numbers>

#include "server/compute/plan.h"
#include "server/compute/quadrature.h"
#include "server/study/host_albedo.h"
#include "server/study/stability.h"

// E, B and 1 - E of the specular lobes: by the quadrature's kernel, and by sampling.
namespace kiln::stability {

namespace {

/// What the rule promises of E and B in double.
constexpr double kAbsolute = 1e-9;

struct Truth {
    double value;
    std::string source;
    double off = 0;  ///< how far it may be off itself
};

/// What a mirror of this masking reflects: 4 NoV^2 V(NoV, NoV).
double mirror(const Lobe& lobe, double NoV) {
    if (lobe.masking != Masking::karis_direct) return 1;
    const double G1 = NoV / (NoV * 0.875 + 0.125);  // k = 1/8
    return G1 * G1;
}

const char* const kOverHalfVectors = "quadrature over half vectors in double";

bool is_smith_ggx(const Lobe& lobe) {
    return lobe.distribution == Distribution::ggx && lobe.masking <= Masking::smith_separable;
}

Truth albedo_truth(const Lobe& lobe, const Place& at, double absolute) {
    const bool correlated = lobe.masking == Masking::smith_correlated;
    if (at.alpha == 0) return {mirror(lobe, at.NoV), "the mirror's limit"};
    if (correlated && at.NoV == 0) return {1, "the limit of correlated Smith"};
    if (is_smith_ggx(lobe) && at.alpha == 1) {
        if (correlated && at.NoV > 1e-9)
            return {1 - at.NoV * std::log1p(1 / at.NoV), "closed form at alpha = 1"};
        if (!correlated)
            return {2 * (1 - std::numbers::ln2) / (1 + at.NoV), "closed form at alpha = 1"};
    }
    return {host_albedo(lobe_of(job_of(lobe)), at.NoV, at.alpha, absolute).E, kOverHalfVectors};
}

Truth bias_truth(const Lobe& lobe, const Place& at, double absolute) {
    if (at.alpha == 0)
        return {std::pow(1 - at.NoV, 5) * mirror(lobe, at.NoV), "the mirror's limit"};
    return {host_albedo(lobe_of(job_of(lobe)), at.NoV, at.alpha, absolute).B, kOverHalfVectors};
}

/// Empty where nothing but the rule itself knows it.
std::optional<Truth> deficit_truth(const Lobe& lobe, const Place& at, double E) {
    if (at.alpha == 0) return Truth{0, "the mirror's limit"};
    if (at.NoV == 0 && lobe.masking == Masking::smith_correlated)
        return Truth{0, "the limit of correlated Smith"};
    if (at.alpha == 1 && at.NoV > 1e-9 && lobe.masking == Masking::smith_correlated)
        return Truth{at.NoV * std::log1p(1 / at.NoV), "closed form at alpha = 1"};
    const double a2 = at.alpha * at.alpha, mu2 = at.NoV * at.NoV, q = at.alpha / at.NoV;
    // The third term is of the order of q^2 ln(1 / q) of the first: 4 to 5 of it by the rule
    // itself.
    if (at.alpha < 1e-3 * mu2) {
        const double first = a2 * (1 + 1 / mu2) / 2;
        return Truth{first * (1 + 4 * q / 3), "its limit as alpha -> 0",
                     8 * q * q * std::log(1 / q) * first};
    }
    if (1 - E > 1e-2) return Truth{1 - E, kOverHalfVectors, kAbsolute};
    return std::nullopt;
}

/// NoV = s alpha, where E falls to .892 however small alpha is, and the corners.
std::vector<Place> rule_places() {
    std::vector<Place> places;
    for (const double alpha : {0.0, 1e-40, 1e-6, 1e-4, 1e-2, 0.25, 1.0}) {
        std::vector<double> cosines{0, 1e-40, 1e-6, 1e-4, 1e-3, 0.1, 0.5, 1};
        if (alpha == 1e-4) cosines.insert(cosines.begin() + 3, {1e-5, 3e-5});
        if (alpha == 1e-4) cosines.insert(cosines.begin() + 6, 3e-4);
        for (const double NoV : cosines) places.push_back({NoV, alpha});
    }
    return places;
}

/// Widths between 0 and the least one of a format count as that (kernels/quadrature.h), and what
/// has no square in it as 0.
Place as_the_rule_sees(const Place& place, const Format& format) {
    Place seen{format.rounded(place.NoV), format.rounded(place.alpha)};
    const double least_alpha = format.single ? 1e-8 : 1e-12;
    const double least_NoV = format.single ? 1e-18 : 1e-25;
    if (seen.alpha > 0) seen.alpha = std::max(seen.alpha, least_alpha);
    if (seen.NoV < least_NoV) seen.NoV = 0;
    return seen;
}

class RulePart {
  public:
    RulePart(Bench& bench, Findings& findings, const Lobe& lobe)
        : bench_(bench), findings_(findings), lobe_(lobe) {}

    void run() {
        const std::vector<Place> places = rule_places();
        const Bench::Sums sums = bench_.run(lobe_.masking, places);
        for (std::size_t i = 0; i < places.size(); ++i) {
            bench_.look();
            const auto readings = [&](std::size_t plane) {
                Readings values;
                for (std::size_t a = 0; a < kArithmetics; ++a)
                    if (!sums[a].empty()) values[a] = sums[a][plane * places.size() + i];
                return values;
            };
            judge(places[i], readings(0), readings(1), readings(2));
        }
    }

  private:
    // Absolute: kAbsolute in double, kQuadratureFloatRounding more in float. Relative, of 1 - E:
    // 1e-6 in float, and 1e-9 at this order in double.
    void judge(const Place& place, Readings E, Readings deficit, Readings B) {
        const Place single = as_the_rule_sees(place, kSingle),
                    twice = as_the_rule_sees(place, kDouble);
        const Truth e32 = albedo_truth(lobe_, single, kAbsolute / 10),
                    e64 = albedo_truth(lobe_, twice, kAbsolute / 10);
        add(place, "E", e64.source, {e32.value, kQuadratureFloatRounding}, {e64.value, kAbsolute},
            E);
        const Truth b32 = bias_truth(lobe_, single, kAbsolute / 10),
                    b64 = bias_truth(lobe_, twice, kAbsolute / 10);
        add(place, "B", b64.source, {b32.value, kQuadratureFloatRounding}, {b64.value, kAbsolute},
            B);
        const auto d64 = deficit_truth(lobe_, twice, e64.value);
        const double d32 = quadrature_deficit(single.NoV, single.alpha, lobe_.masking);
        if (!d64) deficit[kNativeDouble].reset(), deficit[kOpenClDouble].reset();
        const Truth right = d64.value_or(Truth{d32, "the rule in double"});
        add(place, "1 - E", right.source, {d32, 1e-6 * d32},
            {right.value, right.off + 1e-9 * right.value}, deficit);
    }

    void add(const Place& place, const char* quantity, const std::string& source, Right in_float,
             Right in_double, const Readings& values) {
        const std::string name = name_of(lobe_);
        findings_.add({"Quadrature", name, name + ": " + quantity, place_column(place), quantity,
                       "", source, place.NoV, place.alpha, in_float, in_double, values, 0,
                       "the promise of quadrature"});
    }

    Bench& bench_;
    Findings& findings_;
    const Lobe& lobe_;
};

std::vector<Place> sampled_places(const Lobe& lobe) {
    const bool charlie = lobe.distribution == Distribution::charlie;
    std::vector<Place> places;
    for (const double alpha : {0.0, 1e-6, 1e-3, 0.1, 1.0}) {
        if (charlie && alpha < 0.1) continue;  // no light of its peak would be drawn
        for (const double NoV : {0.0, 1e-6, 1e-3, 0.1, 1.0}) {
            if (charlie && NoV == 0) continue;  // infinite, or nearly
            places.push_back({NoV, alpha});
        }
    }
    return places;
}

/// What rules say of the means of a lobe's samples at a place.
struct Albedo {
    Truth E, B, deficit;
};

Albedo albedo_of(const Lobe& lobe, const Place& at) {
    if (at.alpha == 0) {
        const Truth E = albedo_truth(lobe, at, 0);
        return {E, bias_truth(lobe, at, 0), {1 - E.value, E.source}};
    }
    if (is_smith_ggx(lobe)) {
        const QuadratureValue found = quadrature_albedo(at.NoV, at.alpha, lobe.masking);
        const char* const source = "the quadrature";
        return {{found.E, source, kAbsolute},
                {found.B, source, kAbsolute},
                {found.deficit, source, 1e-6 * found.deficit}};
    }
    constexpr double asked = 1e-8, off = 1e-7;
    const HostAlbedo found = host_albedo(lobe_of(job_of(lobe)), at.NoV, at.alpha, asked);
    const double size = std::max(1.0, found.E);
    return {{found.E, kOverHalfVectors, off * size},
            {found.B, kOverHalfVectors, off * size},
            {1 - found.E, kOverHalfVectors, off * size}};
}

/// (1 - VoH)^5 at most, of a light above the horizon: V and L are a right angle and V's own apart.
double bias_most(double NoV) {
    const double sinV = std::sqrt((1 - NoV) * (1 + NoV));
    return std::pow(1 - NoV / std::sqrt(2 * (1 + sinV)), 5);
}

/// Samples of GGX under Smith weigh G2 / G1(V), and at normal view those of all but charlie G2 or
/// less: at most 1, so that what is missing of E is at most 1 - E. Of others the mean or 1 stands
/// for the greatest weight. No sample weighs less than 0.
Expected sampled_expected(const Lobe& lobe, const Place& at, const Albedo& albedo,
                          std::size_t term) {
    const bool bounded =
        is_smith_ggx(lobe) || (at.NoV == 1 && lobe.distribution != Distribution::charlie);
    const Truth& right = term == kSchlick ? albedo.B : term == kDeficit ? albedo.deficit : albedo.E;
    Expected expected{right.value, right.source, right.off};
    const double most = std::max(1.0, albedo.E.value);
    // The deficit of other lobes is a difference from 1.
    expected.rounds_with = term == kDeficit && !is_smith_ggx(lobe) ? most : right.value;
    expected.fifth_power = term == kSchlick;
    if (term == kSchlick) {
        expected.greatest = bias_most(at.NoV) * most;
        expected.all = right.value;
        if (bounded) expected.all = std::min(expected.all, expected.greatest - right.value);
    } else {
        expected.greatest = most;
        const Truth& missing = albedo.deficit;
        expected.all = bounded ? std::max(0.0, missing.value) + missing.off : albedo.E.value;
    }
    if (at.alpha == 0) expected.all = 0;  // a mirror
    return expected;
}

Pointwise sampled_pointwise(const Lobe& lobe) {
    const JobSpec job = job_of(lobe);
    Pointwise p{"Sampled albedos", name_of(lobe), name_of(lobe), lobe_of(job)};
    p.material.general = is_smith_ggx(lobe) ? 0 : kAnyMaterial;
    p.parameters[kExponentParameter] = 5;
    p.terms = {{kWeight, "E"}, {kSchlick, "B"}, {kDeficit, "1 - E"}};
    p.places = sampled_places(lobe);
    p.column = place_column;
    return p;
}

}  // namespace

Part quadrature_part() {
    return {{}, [](Bench& bench, Findings& findings) {
                for (const Lobe& lobe : lobes())
                    if (is_smith_ggx(lobe)) RulePart(bench, findings, lobe).run();
            }};
}

Part sampled_part() {
    Part part;
    for (const Lobe& lobe : lobes())
        part.programs.push_back(
            Specialisation{material_of(sampled_pointwise(lobe)), Precision::float32});
    part.run = [](Bench& bench, Findings& findings) {
        for (const Lobe& lobe : lobes()) {
            const Pointwise p = sampled_pointwise(lobe);
            std::vector<Albedo> albedos;
            for (const Place& place : p.places) {
                bench.look();
                albedos.push_back(albedo_of(lobe, place));
            }
            run_sampled(bench, p, point_kind(p.material), findings,
                        [&](std::size_t place, std::size_t term) {
                            return sampled_expected(lobe, p.places[place], albedos[place], term);
                        });
        }
    };
    return part;
}

}  // namespace kiln::stability
