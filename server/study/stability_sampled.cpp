// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "server/compute/fresnel.h"
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
/// Of sums in float (kernels/batch.h), and of the truth's own quadrature.
constexpr double kRounding = 3e-6, kTruth = 1e-6;

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

std::pair<double, std::string> diffuse_truth(DiffuseModel model, const Place& place,
                                             double albedo) {
    const double r = std::sqrt(place.alpha), sigma2 = r * r;
    if (albedo == 0) return {0, "a black surface"};
    switch (model) {
        case DiffuseModel::lambert:
            return {albedo, "Lambert's albedo"};
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
    return {host_diffuse_albedo(number, place.NoV, r, albedo, kTruth / 10),
            "quadrature over lights in double"};
}

}  // namespace

void run_sampled(Bench& bench, const Pointwise& p, PointKind kind, Findings& findings,
                 const TruthOf& truth) {
    const KernelMaterial material = material_of(p);
    const PointSet set = make_points(Sampler::sobol_owen, kind, bench.job().seed, kSamples);
    const Bench::Sums sums = bench.run(material, p.parameters, set.values, set.batches, p.places);
    for (std::size_t t = 0; t < p.terms.size(); ++t)
        for (std::size_t i = 0; i < p.places.size(); ++i) {
            bench.look();
            const Place& place = p.places[i];
            const auto [right, source] = truth(place, p.terms[t].index);
            Finding found{p.family, p.model, p.row,     p.column(place), p.terms[t].quantity,
                          "",       source,  place.NoV, place.alpha,     {},
                          {},       {},      1};
            double error = 0;
            for (std::size_t a = 0; a < kArithmetics; ++a) {
                if (sums[a].empty()) continue;
                const Mean mean = mean_of(set, sums[a], p.terms.size(), t, p.places.size(), i);
                found.values[a] = mean.value;
                error = std::max(error, mean.standard_error);
            }
            const double size = std::max(1.0, std::abs(right));
            const double chance = kStandardErrors * error + (kUnseen + kTruth) * size;
            found.in_float = {right, chance + kRounding * size};
            found.in_double = {right, chance};
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
        for (const DiffuseModel model : diffuse_lobes())
            run_sampled(bench, diffuse_pointwise(model), PointKind::cosine_diffuse, findings,
                        [&](const Place& place, std::size_t term) {
                            return diffuse_truth(model, place, kAlbedos[term - kDiffuse]);
                        });
    };
    return part;
}

}  // namespace kiln::stability
