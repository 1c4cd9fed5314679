// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "server/compute/plan.h"
#include "server/compute/quadrature.h"
#include "server/study/host_albedo.h"
#include "server/study/stability.h"

// Quadrature beyond Smith's GGX: the other lobes and maskings, and under Fresnel terms, among them
// total reflection. As jobs take it: orders raised until two agree.
namespace kiln::stability {

namespace {

/// Places are the same numbers in float and in double: 2^-20, 2^-10, 1/8.
constexpr double kTiny = 0x1p-20, kSmall = 0x1p-10, kEighth = 0.125;
/// Of the integral over half vectors, itself good to some 4e-9 of wide lobes at grazing views; what
/// the rule promises is 2e-9.
constexpr double kAbsolute = 6e-9;
constexpr double kTruth = 1e-10;

struct Rule {
    std::string name;
    KernelMaterial lobe;
    FresnelModel fresnel{.model = Fresnel::none};  ///< none: E, and B under Schlick's weight
    std::vector<Place> places{};
    bool on_opencl = false;  ///< one of each kernel: the others have its bits by their own test

    bool coloured() const { return fresnel.model != Fresnel::none; }
    QuadratureParameters parameters() const {
        QuadratureParameters p{};
        if (!coloured()) return p;
        const auto numbers = fresnel_parameters(fresnel, 0);
        std::copy(numbers.begin(), numbers.end(), p.begin());
        return p;
    }
    QuadratureKind kind() const {
        const int term = coloured() ? fresnel_function(fresnel) : kSchlickWeight;
        return quadrature_kind(lobe, term, parameters(), Precision::float32);
    }
};

std::vector<Place> places_of(const Lobe& lobe) {
    const bool charlie = lobe.distribution == Distribution::charlie;
    std::vector<Place> places;
    for (const double alpha : {0.0, kTiny, kSmall, kEighth, 1.0}) {
        if (charlie && alpha < kSmall) continue;  // its D is a pole at the horizon
        for (const double NoV : {0.0, kTiny, kSmall, kEighth, 1.0})
            if (!charlie || NoV > 0) places.push_back({NoV, alpha});
    }
    return places;
}

std::vector<Place> places_of(const FresnelModel&) {
    std::vector<Place> places;
    for (const double alpha : {0.0, 0x1p-40, kEighth, 1.0})
        for (const double NoV : {kSmall, 0.5, 1.0}) places.push_back({NoV, alpha});
    return places;
}

std::vector<Rule> rules() {
    std::vector<Rule> all;
    for (const Lobe& lobe : lobes()) {
        if (lobe.distribution == Distribution::ggx && lobe.masking <= Masking::smith_separable)
            continue;  // quadrature_part() has them
        all.push_back({name_of(lobe),
                       lobe_of(job_of(lobe)),
                       {.model = Fresnel::none},
                       places_of(lobe),
                       lobe.softened});
    }
    for (const FresnelRow& row : fresnel_rows()) {
        const bool inside = row.model.model == Fresnel::dielectric && row.model.ior[0] < 1;
        if (!inside && row.model.model != Fresnel::conductor) continue;
        all.push_back(
            {row.name, lobe_of(job_of(lobes().front())), row.model, places_of(row.model), true});
    }
    return all;
}

double mirror_F(const Rule& rule, double NoV) {
    return rule.coloured() ? fresnel(rule.fresnel, 0, NoV) : std::pow(1 - NoV, 5);
}

/// How far F of a mirror moves as the float that the kernels read of an ior, (ior - 1)(ior + 1),
/// moves by a unit: at 1e-4 total reflection begins within that of VoH = 1.
double mirror_spread(const Rule& rule, const Place& at) {
    if (rule.fresnel.model != Fresnel::dielectric || at.alpha >= 1e-9) return 0;
    const double ior = rule.fresnel.ior[0], given = (ior - 1) * (ior + 1);
    double most = 0;
    for (const double moved : {given * (1 - 0x1p-23), given * (1 + 0x1p-23)}) {
        FresnelModel other = rule.fresnel;
        other.ior[0] = std::sqrt(std::max(1 + moved, 1e-8));
        most = std::max(most, std::abs(fresnel(other, 0, at.NoV) - mirror_F(rule, at.NoV)));
    }
    return most;
}

/// {E, B}, and where from.
std::pair<HostAlbedo, std::string> truth_of(const Rule& rule, const Place& at) {
    if (at.alpha < 1e-9) {
        double G = 1;
        if (rule.lobe.masking == static_cast<int>(Masking::karis_direct)) {
            const double G1 = at.NoV / (at.NoV * 0.875 + 0.125);  // k = 1/8
            G = G1 * G1;
        }
        return {{G, G * mirror_F(rule, at.NoV)}, "the mirror's limit"};
    }
    HostFresnel F{[&](double VoH) { return fresnel(rule.fresnel, 0, VoH); }};
    if (rule.fresnel.model == Fresnel::dielectric) {
        const double ior = rule.fresnel.ior[0];
        F.kink = std::sqrt((1 - ior) * (1 + ior));
    }
    const HostAlbedo found = rule.coloured() ? host_albedo(rule.lobe, at.NoV, at.alpha, kTruth, F)
                                             : host_albedo(rule.lobe, at.NoV, at.alpha, kTruth);
    return {found, "quadrature over half vectors in double"};
}

void run_rule(Bench& bench, Findings& findings, const Rule& rule) {
    const QuadratureKind kind = rule.kind();
    const Bench::Sums sums = bench.run(kind, rule.parameters(), rule.places, rule.on_opencl);
    const std::size_t count = rule.places.size();
    for (std::size_t i = 0; i < count; ++i) {
        bench.look();
        const Place& place = rule.places[i];
        const auto [right, source] = truth_of(rule, place);
        for (std::size_t plane = rule.coloured() ? 1 : 0; plane < 2; ++plane) {
            const double value = plane == 0 ? right.E : right.B;
            const double size = std::max(1.0, value);
            const double in_float = (kAbsolute + quadrature_float_rounding(kind)) * size +
                                    (plane == 0 ? 0 : mirror_spread(rule, place));
            Readings values;
            for (std::size_t a = 0; a < kArithmetics; ++a)
                if (!sums[a].empty()) values[a] = sums[a][plane * count + i];
            const std::string quantity = plane == 0 ? "E" : rule.coloured() ? "albedo" : "B";
            findings.add(
                {rule.coloured() ? "Quadrature under Fresnel terms" : "Quadrature of other lobes",
                 "quadrature, " + rule.name,
                 rule.coloured() ? rule.name : rule.name + ": " + quantity,
                 place_column(place),
                 quantity,
                 "",
                 source,
                 place.NoV,
                 place.alpha,
                 {value, in_float},
                 {value, kAbsolute * size},
                 values,
                 0,
                 "the promise of quadrature"});
        }
    }
}

}  // namespace

Part rules_part() {
    Part part;
    for (const Rule& rule : rules())
        if (rule.on_opencl) part.programs.push_back(rule.kind());
    part.run = [](Bench& bench, Findings& findings) {
        for (const Rule& rule : rules()) run_rule(bench, findings, rule);
    };
    return part;
}

}  // namespace kiln::stability
