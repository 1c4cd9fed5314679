// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "server/compute/fresnel.h"
#include "server/compute/plan.h"
#include "server/spec/words.h"
#include "server/study/stability.h"

// Every model of the contract, one sample at a time, on extreme inputs.
namespace kiln::stability {

namespace {

/// A square that is subnormal in float and one that is not; the corners; the middle.
const double kCosines[] = {0, 1e-40, 1e-6, 1e-3, 0.1, 0.5, 1};
const double kAlphas[] = {0, 1e-40, 1e-12, 1e-6, 1e-3, 0.1, 0.5, 1};

std::vector<Place> grid(std::span<const double> alphas) {
    std::vector<Place> places;
    for (const double alpha : alphas)
        for (const double NoV : kCosines) places.push_back({NoV, alpha});
    return places;
}

std::vector<KernelKind> programs_of(const std::vector<Pointwise>& all) {
    std::vector<KernelKind> programs;
    for (const Pointwise& p : all)
        programs.push_back(Specialisation{material_of(p), Precision::float32});
    return programs;
}

Part part_of(std::vector<Pointwise> all) {
    std::vector<KernelKind> programs = programs_of(all);
    return {std::move(programs), [all = std::move(all)](Bench& bench, Findings& findings) {
                for (const Pointwise& p : all) run(bench, p, findings);
            }};
}

double one(const Place&) { return 1; }

FresnelModel schlick(double f0, double f90 = 1, double exponent = 5) {
    return {.f0 = {f0}, .f90 = {f90}, .exponent = exponent};
}
FresnelModel dielectric(double ior) { return {.model = Fresnel::dielectric, .ior = {ior}}; }
FresnelModel conductor(double eta, double k) {
    return {.model = Fresnel::conductor, .eta = {eta}, .k = {k}};
}
FresnelModel edge_tint(double reflectivity, double tint) {
    return {.model = Fresnel::edge_tint, .reflectivity = {reflectivity}, .edge_tint = {tint}};
}
FresnelModel f82(double f0, double tint) {
    return {.model = Fresnel::f82_tint, .f0 = {f0}, .f82 = {tint}};
}

/// Born, Wolf, Principles of Optics, sections 1.5.2 and 14.2, at normal incidence.
double normal(double eta, double k = 0) {
    return ((eta - 1) * (eta - 1) + k * k) / ((eta + 1) * (eta + 1) + k * k);
}

std::string model_word(const FresnelModel& model) { return std::string(to_word(model.model)); }

void set_fresnel(Pointwise& p, const FresnelModel& model, std::size_t channel) {
    const auto numbers = fresnel_parameters(model, 0);
    std::copy(numbers.begin(), numbers.end(),
              p.parameters.begin() + static_cast<std::ptrdiff_t>(channel * numbers.size()));
}

/// F where it is known in closed form: at 0 and 90 degrees; of a metal that absorbs nothing; at the
/// angle at which a tint of 0 puts F82 to 0.
std::optional<double> closed_F(const FresnelRow& row, double VoH) {
    const FresnelModel& F = row.model;
    if (VoH == 1) return row.at_normal;
    if (VoH == 0) return row.at_grazing;
    if (F.model == Fresnel::conductor && F.eta[0] == 0) return 1;
    if (F.model == Fresnel::f82_tint && F.f82[0] == 0 && VoH == 1.0 / 7) return 0;
    return std::nullopt;
}

/// At alpha = 0 the lobe is a mirror of weight 1, so its coloured term is F(NoV).
Pointwise reflected(const FresnelRow& row) {
    Pointwise p{"Fresnel", "F " + model_word(row.model), row.name, {}};
    p.material = {.fresnel = fresnel_function(row.model), .general = kAnyMaterial};
    set_fresnel(p, row.model, 0);
    // F0 + (F90 - F0) (1 - VoH)^n and the like are sums to which 1 is large.
    const Fresnel model = row.model.model;
    const bool sum = model == Fresnel::schlick || model == Fresnel::f82_tint;
    p.terms = {{kColour, "F", [sum](const Place&) { return sum ? 1.0 : 0.0; }}};
    p.points = {{"", visible_normal_point(1, 0.5)}};
    for (const double VoH : {0.0, 1e-40, 1e-6, 1e-4, 1e-3, 0.01, 0.1, 1.0 / 7, 0.5,
                             0.74535599249993, 0.9, 1 - 0x1p-20, 1.0})
        p.places.push_back({VoH, 0});
    p.column = [](const Place& place) { return plain(place.NoV); };
    p.closed = [row](const Place& place) { return closed_F(row, place.NoV); };
    p.closed_source = "closed form";
    return p;
}

/// 1 − F under a white Lambert lobe, from the light at the pole or from the horizon opposite.
Pointwise transmitted(const FresnelRow& row, bool pole) {
    Pointwise p{"Fresnel", "F " + model_word(row.model), row.name, {}};
    p.material = {.importance = static_cast<int>(Importance::cosine),
                  .fresnel = fresnel_function(row.model),
                  .general = kAnyMaterial};
    set_fresnel(p, row.model, 0);
    p.parameters[kAlbedoParameter] = 1;
    p.terms = {{kTransmitted, "1 - F", one}};  // a difference from 1
    if (pole)
        p.points = {{"L = N", {1, 1, 0, 0}}};
    else
        p.points = {{"L at the horizon", {-1, 0, 1, 0}}};
    for (const double NoV : {0.0, 1e-6, 1e-3, 0.1, 0.5, 0.9, 1.0}) p.places.push_back({NoV, 0});
    p.column = [](const Place& place) { return plain(place.NoV); };
    // VoH there is the root of (1 + L·V) / 2.
    p.closed = [row, pole](const Place& place) -> std::optional<double> {
        const double LoV = pole ? place.NoV : -std::sqrt((1 - place.NoV) * (1 + place.NoV));
        const auto F = closed_F(row, std::sqrt((1 + LoV) / 2));
        return F ? std::optional(1 - *F) : std::nullopt;
    };
    p.closed_source = "closed form";
    return p;
}

/// The weight of a cosine-distributed light, π D V (of a uniform one, 2π NoL D V), at the mirror
/// direction and off it.
Pointwise lobe_value(const Lobe& lobe) {
    JobSpec job = job_of(lobe);
    const bool charlie = lobe.distribution == Distribution::charlie;
    if (!charlie) job.importance = Importance::cosine;
    Pointwise p{"Lobes: pi D V", name_of(lobe), name_of(lobe), lobe_of(job)};
    p.material.general = kAnyMaterial;
    p.material.terms = 1 << kWeight | 1 << kSchlick | 1 << kDeficit;  // as sampled_part() has it
    p.parameters[kExponentParameter] = 5;
    // Its masking is the exponential of up to 14 (softened, 42), made in some eight operations.
    if (lobe.masking == Masking::charlie) p.forward_units += 8 * (lobe.softened ? 42 : 14);
    p.terms = {{kWeight, charlie ? "2 pi NoL D V" : "pi D V"}};
    for (const double NoL : {1e-6, 1e-3, 0.1, 0.5, 1.0})
        for (const double cos_phi : {-1.0, 0.0, 1.0}) {
            const double sinL = std::sqrt((1 - NoL) * (1 + NoL));
            p.points.push_back(
                {"NoL " + plain(NoL) + ", cos phi " + plain(cos_phi), {cos_phi, NoL, sinL, 0}});
        }
    p.places = grid(kAlphas);
    p.column = place_column;
    return p;
}

/// A sample of the visible normals on the fast path: G2 / G1, its part under F90, and 1 − G2 / G1.
Pointwise fast_sample(const Lobe& lobe) {
    const JobSpec job = job_of(lobe);
    Pointwise p{"Samples of visible normals", name_of(lobe), "", lobe_of(job)};
    p.rows_by_quantity = true;
    // At normal view a sample's own deficit vanishes as the light rises; their mean is alpha^2.
    const auto mean = [](const Place& place) { return place.alpha * place.alpha; };
    p.terms = {{kWeight, "G2/G1"}, {kSchlick, "F90's part", one}, {kDeficit, "1 - G2/G1", mean}};
    for (const double u : {1e-7, 1e-3, 0.5, 0.999})
        for (const double cos_phi : {-1.0, 0.0, 1.0})
            p.points.push_back({"u " + plain(u) + ", cos phi " + plain(cos_phi),
                                visible_normal_point(cos_phi, u)});
    p.places = grid(kAlphas);
    p.column = place_column;
    return p;
}

/// π f at roughness √alpha, for a black, a grey and a white surface.
Pointwise diffuse_value(DiffuseModel model) {
    const std::string name(to_word(model));
    Pointwise p{"Diffuse: pi f", name, name, {}};
    p.material = {.importance = static_cast<int>(Importance::cosine),
                  .diffuse = static_cast<int>(model) - static_cast<int>(DiffuseModel::lambert),
                  .general = kAnyMaterial};
    const double albedos[] = {0, 0.5, 1};
    for (std::size_t c = 0; c < 3; ++c) {
        p.parameters[kAlbedoParameter + c] = albedos[c];
        p.terms.push_back({kDiffuse + c, "albedo " + plain(albedos[c]),
                           [a = albedos[c]](const Place&) { return a; }});
    }
    for (const double NoL : {1e-6, 1e-3, 0.5, 1.0})  // no sampler draws 0
        for (const double cos_phi : {-1.0, 0.0, 1.0})
            p.points.push_back({"NoL " + plain(NoL) + ", cos phi " + plain(cos_phi),
                                {cos_phi, NoL, std::sqrt((1 - NoL) * (1 + NoL)), 0}});
    const double alphas[] = {0, 1e-40, 1e-6, 1e-3, 0.25, 1};
    p.places = grid(alphas);
    p.column = place_column;
    return p;
}

}  // namespace

std::vector<FresnelRow> fresnel_rows() {
    const double just_above = 1 + 1e-7, just_below = 1 - 1e-7;
    return {
        {"none", {.model = Fresnel::none}, 1},
        {"schlick, F0 0", schlick(0), 0},
        {"schlick, F0 1", schlick(1), 1},
        {"schlick, F0 1, F90 0", schlick(1, 0), 1, 0},
        {"schlick, exponent 0.001", schlick(0.04, 1, 0.001), 0.04},
        {"schlick, exponent 1000", schlick(0.04, 1, 1000), 0.04},
        {"dielectric, 1e-4", dielectric(1e-4), normal(1e-4)},
        {"dielectric, 1/1.5", dielectric(1 / 1.5), normal(1 / 1.5)},
        {"dielectric, 1 - 1e-7", dielectric(just_below), normal(just_below)},
        {"dielectric, 1", dielectric(1), 0, 0},  // no interface: 0 at every angle
        {"dielectric, 1 + 1e-7", dielectric(just_above), normal(just_above)},
        {"dielectric, 1.5", dielectric(1.5), 0.04},
        {"dielectric, 1e3", dielectric(1e3), normal(1e3)},
        {"dielectric, 1e6", dielectric(1e6), normal(1e6)},
        {"conductor, 1e-4 + 5i", conductor(1e-4, 5), normal(1e-4, 5)},
        {"conductor, 0 + 5i", conductor(0, 5), 1},
        {"conductor, 1 + 1e-6i", conductor(1, 1e-6), normal(1, 1e-6)},
        {"conductor, 1.5 + 0i", conductor(1.5, 0), 0.04},
        {"conductor, 0.18 + 3.4i", conductor(0.18, 3.4), normal(0.18, 3.4)},
        {"conductor, 1e5 + 1e5i", conductor(1e5, 1e5), normal(1e5, 1e5)},
        {"conductor, 1e6 + 1e6i", conductor(1e6, 1e6), normal(1e6, 1e6)},
        {"edge_tint, 0, g 0", edge_tint(0, 0), 0, 0},  // its index is 1
        {"edge_tint, 0.99999, g 0", edge_tint(0.99999, 0), 0.99999},
        {"edge_tint, 0.99999, g 1", edge_tint(0.99999, 1), 0.99999},
        {"f82_tint, F0 0, F82 0", f82(0, 0), 0},
        {"f82_tint, F0 1, F82 0", f82(1, 0), 1},
        {"f82_tint, F0 0.04, F82 1", f82(0.04, 1), 0.04},
    };
}

const std::vector<Lobe>& lobes() {
    static const std::vector<Lobe> all = {
        {Distribution::ggx, Masking::smith_correlated},
        {Distribution::ggx, Masking::smith_separable},
        {Distribution::ggx, Masking::karis_ibl},
        {Distribution::ggx, Masking::karis_direct},
        {Distribution::ggx, Masking::unreal_joint},
        {Distribution::beckmann, Masking::smith_correlated},
        {Distribution::beckmann, Masking::smith_separable},
        {Distribution::charlie, Masking::neubelt},
        {Distribution::charlie, Masking::charlie},
        {Distribution::charlie, Masking::charlie, true},
    };
    return all;
}

std::string name_of(const Lobe& lobe) {
    return std::string(to_word(lobe.distribution)) + ", " + std::string(to_word(lobe.masking)) +
           (lobe.softened ? ", softened" : "");
}

JobSpec job_of(const Lobe& lobe) {
    JobSpec job;
    job.distribution = lobe.distribution;
    job.masking = lobe.masking;
    job.terminator_softening = lobe.softened;
    job.importance = lobe.distribution == Distribution::ggx        ? Importance::vndf
                     : lobe.distribution == Distribution::beckmann ? Importance::ndf
                                                                   : Importance::uniform;
    return job;
}

std::string place_column(const Place& place) {
    const auto word = [](double value) {
        int exponent = 0;
        const bool power = std::frexp(value, &exponent) == 0.5 && exponent < -5;
        return power ? "2^" + std::to_string(exponent - 1) : plain(value);
    };
    return word(place.alpha) + kPlaceJoint + word(place.NoV);
}

Part fresnel_part() {
    std::vector<Pointwise> all;
    for (const FresnelRow& row : fresnel_rows()) {
        all.push_back(reflected(row));
        for (const bool pole : {true, false}) all.push_back(transmitted(row, pole));
    }
    return part_of(std::move(all));
}

Part lobes_part() {
    std::vector<Pointwise> all;
    for (const Lobe& lobe : lobes()) {
        all.push_back(lobe_value(lobe));
        if (lobe.distribution == Distribution::ggx && lobe.masking <= Masking::smith_separable)
            all.push_back(fast_sample(lobe));
    }
    return part_of(std::move(all));
}

Part diffuse_part() {
    std::vector<Pointwise> all;
    for (const DiffuseModel model : diffuse_lobes()) all.push_back(diffuse_value(model));
    return part_of(std::move(all));
}

}  // namespace kiln::stability
