// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "server/compute/fresnel.h"
#include "server/compute/quadrature.h"
#include "server/spec/words.h"
#include "server/study/host_albedo.h"
#include "server/study/stability.h"

// Means over a sampler's points, and the averages that the host makes.
namespace kiln::stability {

namespace {

constexpr std::int64_t kSamples = 1 << 16;
/// Replicates agree within this many standard errors: of some thousand values, one in 1e3 runs
/// passes it by chance (Student's t of 15 degrees).
constexpr double kStandardErrors = 7;
/// Events that no replicate saw may be this many: one in e^8 = 3000 values.
constexpr double kUnseen = 8.0 / kSamples;
/// A share p of random events is so many standard errors, sqrt(p / N), above 0 from here on.
constexpr double kTold = kStandardErrors * kStandardErrors / kSamples;
/// Units of sums (kernels/batch.h), and of a half vector's cosine.
constexpr double kSumUnits = 50, kCosineUnits = 16;
/// Of the integral over lights in double.
constexpr double kTruth = 1e-6;

struct Mean {
    double value = 0, standard_error = 0;
};

Mean mean_of(const PointSet& set, const std::vector<double>& sums, std::size_t terms,
             std::size_t term, std::size_t places, std::size_t place) {
    std::vector<double> replicates(set.replicate_sizes.size());
    for (std::size_t b = 0; b < set.batches.size(); ++b)
        replicates[set.replicate_of_batch[b]] += sums[(b * terms + term) * places + place];
    const auto count = static_cast<double>(replicates.size());
    Mean mean;
    for (std::size_t r = 0; r < replicates.size(); ++r) {
        replicates[r] /= set.replicate_sizes[r];
        mean.value += replicates[r] / count;
    }
    double squares = 0;
    for (const double r : replicates) squares += (r - mean.value) * (r - mean.value);
    mean.standard_error = std::sqrt(squares / (count * (count - 1)));
    return mean;
}

/// By Minkowski: where x is off by c at most, the root of the mean of x^5 is.
double rounding(const Expected& right, const Format& format) {
    double most = kSumUnits * format.unit * right.rounds_with + format.underflow;
    if (right.fifth_power)
        most += std::pow(std::pow(right.value, 0.2) + kCosineUnits * format.unit, 5) - right.value;
    return most;
}

const double kAlbedos[] = {0, 0.5, 1};

Pointwise diffuse_pointwise(DiffuseModel model) {
    const std::string name(to_word(model));
    Pointwise p{"Diffuse albedos", name, name, {}};
    p.material = {.importance = static_cast<int>(Importance::cosine),
                  .diffuse = static_cast<int>(model) - static_cast<int>(DiffuseModel::lambert),
                  .general = kAnyMaterial};
    for (std::size_t c = 0; c < 3; ++c) {
        p.parameters[kAlbedoParameter + c] = kAlbedos[c];
        p.terms.push_back({kDiffuse + c, "albedo " + plain(kAlbedos[c])});
    }
    for (const double alpha : {0.0, 1e-6, 0.25, 1.0})
        for (const double NoV : {0.0, 1e-6, 1e-3, 0.1, 1.0}) p.places.push_back({NoV, alpha});
    p.column = place_column;
    return p;
}

/// Portsmouth, Kutz, Hill 2025, eq. 5: the albedo of white FON, exact.
double fon_albedo(double NoV, double roughness) {
    constexpr double pi = 3.14159265358979323846;
    const double S = std::sqrt((1 - NoV) * (1 + NoV));
    const double G =
        S * (std::acos(NoV) - S * NoV) + 2.0 / 3 * S * (NoV * (1 + S + S * S) / (1 + S) - 1);
    const double scale = 1 / (1 + (0.5 - 2 / (3 * pi)) * roughness);
    return scale * (1 + roughness * G / pi);
}

/// Where f is the same for all directions.
bool is_constant(DiffuseModel model, double alpha) {
    const bool falls = model == DiffuseModel::burley || model == DiffuseModel::burley_normalized ||
                       model == DiffuseModel::chan2018;
    return model == DiffuseModel::lambert || (alpha == 0 && !falls);
}

/// Of no sample: where from, and its own error.
Expected diffuse_truth(DiffuseModel model, const Place& place, double albedo, double off) {
    const double r = std::sqrt(place.alpha), sigma2 = r * r;
    if (albedo == 0) return {0, "a black surface"};
    if (is_constant(model, place.alpha)) return {albedo, "Lambert's albedo"};
    switch (model) {
        case DiffuseModel::fon:
            return {albedo * fon_albedo(place.NoV, r), "closed form"};
        case DiffuseModel::eon:
            if (albedo == 1) return {1, "EON preserves energy"};
            break;
        case DiffuseModel::burley:
            if (place.NoV == 1) return {albedo * (1 + (r - 0.5) / 21 + r / 84), "closed form"};
            break;
        case DiffuseModel::oren_nayar:
            if (place.NoV == 1) return {albedo * (1 - sigma2 / (2 * (sigma2 + 0.33))), "A"};
            break;
        default:
            break;
    }
    const int number = static_cast<int>(model) - static_cast<int>(DiffuseModel::lambert);
    return {host_diffuse_albedo(number, place.NoV, r, albedo, off / 10),
            "quadrature over lights in double", off};
}

Expected diffuse_expected(DiffuseModel model, const Place& place, double albedo) {
    Expected right = diffuse_truth(model, place, albedo, kTruth);
    right.rounds_with = std::max(right.value, albedo);
    right.greatest = right.all = right.rounds_with;
    if (albedo == 0 || is_constant(model, place.alpha)) right.all = 0;
    return right;
}

/// 2^-20 and 2^-10, the same numbers in float and in double, as are their roots.
constexpr double kTiny = 0x1p-20, kSmall = 0x1p-10;

/// One of the kernels on OpenCL, too: the others have its bits by their own test.
bool on_opencl(DiffuseModel model) { return model == DiffuseModel::eon; }

/// chan2018 has the root of NoH in an exponent, which vanishes between opposite horizons: below
/// NoV 1/8 no order settles, and order 112 is off by 8e-6 at 2^-10. eon_unreal has a floor of 1e-6
/// under its divisor, which the integral over lights does not see at NoV 0: 3e-7 of it.
bool is_known(DiffuseModel model, double NoV) {
    if (model == DiffuseModel::chan2018) return NoV >= 0.125;
    return model != DiffuseModel::eon_unreal || NoV > 0;
}

QuadratureKind diffuse_rule(DiffuseModel model) {
    const int number = static_cast<int>(model) - static_cast<int>(DiffuseModel::lambert);
    return {DiffuseRule{number}, Precision::float32};
}

void run_diffuse_rule(Bench& bench, Findings& findings, DiffuseModel model, double albedo) {
    // What the rule promises, server/compute/quadrature.h, and the integral over lights may be off.
    constexpr double promised = 2e-9, off = 1e-8;
    std::vector<Place> places;
    for (const double alpha : {0.0, kTiny, 0.25, 1.0})
        for (const double NoV : {0.0, kTiny, kSmall, 0.125, 1.0})
            if (is_known(model, NoV)) places.push_back({NoV, alpha});
    const QuadratureKind kind = diffuse_rule(model);
    QuadratureParameters parameters{};
    parameters.back() = albedo;
    const Bench::Sums sums = bench.run(kind, parameters, places, on_opencl(model));
    const std::string name(to_word(model)), quantity = "albedo " + plain(albedo);
    for (std::size_t i = 0; i < places.size(); ++i) {
        bench.look();
        const Place& place = places[i];
        const Expected right = diffuse_truth(model, place, albedo, off);
        const double size = std::max(1.0, right.value), in_double = promised * size + right.off;
        Readings values;
        for (std::size_t a = 0; a < kArithmetics; ++a)
            if (!sums[a].empty()) values[a] = sums[a][i];
        findings.add({"Quadrature of diffuse lobes",
                      "quadrature, " + name,
                      name + ": " + quantity,
                      place_column(place),
                      quantity,
                      "",
                      right.source,
                      place.NoV,
                      place.alpha,
                      {right.value, in_double + quadrature_float_rounding(kind) * size},
                      {right.value, in_double},
                      values,
                      0,
                      "the promise of quadrature"});
    }
}

}  // namespace

Part diffuse_rules_part() {
    Part part;
    for (const DiffuseModel model : diffuse_lobes())
        if (on_opencl(model)) part.programs.push_back(diffuse_rule(model));
    part.run = [](Bench& bench, Findings& findings) {
        for (const DiffuseModel model : diffuse_lobes())
            for (const double albedo : {0.5, 1.0}) run_diffuse_rule(bench, findings, model, albedo);
    };
    return part;
}

void run_sampled(Bench& bench, const Pointwise& p, PointKind kind, Findings& findings,
                 const ExpectedOf& expected) {
    const KernelMaterial material = material_of(p);
    const PointSet set = make_points(Sampler::sobol_owen, kind, bench.job().seed, kSamples);
    const Bench::Sums sums = bench.run(material, p.parameters, set.values, set.batches, p.places);
    for (std::size_t t = 0; t < p.terms.size(); ++t)
        for (std::size_t i = 0; i < p.places.size(); ++i) {
            bench.look();
            const Place& place = p.places[i];
            const Expected right = expected(i, p.terms[t].index);
            const double told = kTold * right.greatest + right.off;
            if (right.all > 0 && std::abs(right.value) < told) continue;
            Finding found{p.family, p.model,      p.row,     p.column(place), p.terms[t].quantity,
                          "",       right.source, place.NoV, place.alpha,     {},
                          {},       {},           1};
            double error = 0;
            for (std::size_t a = 0; a < kArithmetics; ++a) {
                if (sums[a].empty()) continue;
                const Mean mean = mean_of(set, sums[a], p.terms.size(), t, p.places.size(), i);
                found.values[a] = mean.value;
                if (right.all > 0) error = std::max(error, mean.standard_error);
            }
            const double unseen = std::min(kUnseen * right.greatest, right.all);
            const double chance = kStandardErrors * error + unseen + right.off;
            found.in_float = {right.value, chance + rounding(right, kSingle)};
            found.in_double = {right.value, chance + rounding(right, kDouble)};
            found.limit = "7 standard errors, what no sample saw, and rounding";
            findings.add(std::move(found));
        }
}

Part diffuse_albedo_part() {
    Part part;
    for (const DiffuseModel model : diffuse_lobes())
        part.programs.push_back(
            Specialisation{material_of(diffuse_pointwise(model)), Precision::float32});
    part.run = [](Bench& bench, Findings& findings) {
        for (const DiffuseModel model : diffuse_lobes()) {
            const Pointwise p = diffuse_pointwise(model);
            run_sampled(bench, p, PointKind::cosine_diffuse, findings,
                        [&](std::size_t place, std::size_t term) {
                            return diffuse_expected(model, p.places[place],
                                                    kAlbedos[term - kDiffuse]);
                        });
        }
    };
    return part;
}

}  // namespace kiln::stability
