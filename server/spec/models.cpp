// SPDX-License-Identifier: Apache-2.0
#include "server/spec/models.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "server/spec/channels.h"
#include "server/spec/json_text.h"
#include "server/spec/layouts.h"
#include "server/spec/words.h"

namespace kiln {
namespace {

using Json = nlohmann::json;
using Numbers = std::vector<double> FresnelModel::*;

/// A field of `fresnel` that holds one number or three, and the models that read it.
struct ColourField {
    const char* name;
    Numbers numbers;
    std::initializer_list<Fresnel> models;
};
const ColourField kColourFields[] = {
    {"f0", &FresnelModel::f0, {Fresnel::schlick, Fresnel::f82_tint}},
    {"f90", &FresnelModel::f90, {Fresnel::schlick}},
    {"ior", &FresnelModel::ior, {Fresnel::dielectric}},
    {"eta", &FresnelModel::eta, {Fresnel::conductor}},
    {"k", &FresnelModel::k, {Fresnel::conductor}},
    {"reflectivity", &FresnelModel::reflectivity, {Fresnel::edge_tint}},
    {"edge_tint", &FresnelModel::edge_tint, {Fresnel::edge_tint}},
    {"f82", &FresnelModel::f82, {Fresnel::f82_tint}},
};

bool reads(const ColourField& field, Fresnel model) {
    return std::find(field.models.begin(), field.models.end(), model) != field.models.end();
}

std::vector<double> numbers_of(const Json& value) {
    // Adding 0 turns −0 into 0, so that both are the same job.
    if (value.is_number()) return {value.get<double>() + 0.0};
    std::vector<double> numbers;
    for (const Json& entry : value) numbers.push_back(entry.get<double>() + 0.0);
    return numbers;
}

Json to_json(const std::vector<double>& numbers) {
    return numbers.size() == 1 ? Json(numbers[0]) : Json(numbers);
}

class Models {
  public:
    Models(const Json& document, ProblemList& problems, JobSpec& job)
        : document_(document), problems_(problems), job_(job) {}

    void read() {
        read_lobe();
        read_fresnel();
        read_diffuse();
        word(job_.coupling, "/coupling");
        word(job_.multiscatter, "/multiscatter");
        check_together();
    }

  private:
    template <JobEnum E>
    void word(E& field, const char* pointer) {
        const Json::json_pointer at(pointer);
        if (!problems_.sound(pointer) || !document_.contains(at)) return;
        field = from_word<E>(document_.at(at).get_ref<const std::string&>()).value();
    }

    void add(const char* pointer, const std::string& message) { problems_.add(pointer, message); }

    bool given(const char* pointer) const {
        return document_.contains(Json::json_pointer(pointer));
    }

    void read_lobe() {
        word(job_.distribution, "/microfacet/distribution");
        if (!problems_.sound("/microfacet/distribution")) return;
        const bool charlie = job_.distribution == Distribution::charlie;
        if (charlie) job_.masking = Masking::neubelt;
        const LayoutPreset* preset = layout_preset(job_.layout);
        if (preset && job_.distribution == Distribution::ggx) job_.masking = preset->masking;
        if (charlie) job_.importance = Importance::uniform;
        word(job_.masking, "/microfacet/masking");
        word(job_.importance, "/importance");
        if (problems_.sound("/microfacet/masking")) check_masking();
        if (problems_.sound("/importance")) check_importance();
        if (!given("/microfacet/terminator_softening") ||
            !problems_.sound("/microfacet/terminator_softening"))
            return;
        job_.terminator_softening = document_["microfacet"]["terminator_softening"].get<bool>();
        if (job_.terminator_softening && job_.masking != Masking::charlie)
            add("/microfacet/terminator_softening", "is a part of masking \"charlie\" alone");
    }

    void check_masking() {
        const bool cloth = job_.masking == Masking::neubelt || job_.masking == Masking::charlie;
        const bool smith = job_.masking <= Masking::smith_separable;
        const std::string word = in_quotes(to_word(job_.masking));
        switch (job_.distribution) {
            case Distribution::ggx:
                if (cloth)
                    add("/microfacet/masking",
                        word +
                            " goes with distribution \"charlie\" alone; ggx takes the Smith, "
                            "Karis and Unreal forms");
                return;
            case Distribution::beckmann:
                if (!smith)
                    add("/microfacet/masking",
                        word +
                            " was made for another distribution; beckmann takes its own Smith "
                            "forms: smith_correlated, smith_separable");
                return;
            case Distribution::charlie:
                if (!cloth)
                    add("/microfacet/masking",
                        word +
                            " has no form for distribution \"charlie\", whose Smith integral is "
                            "the fit \"charlie\"; allowed: charlie, neubelt");
                return;
        }
    }

    void check_importance() {
        if (job_.distribution != Distribution::charlie) return;
        if (job_.importance == Importance::vndf)
            add("/importance",
                "\"vndf\" draws normals that Smith's masking lets be seen, and charlie has no such "
                "masking; allowed: cosine, uniform");
        if (job_.importance == Importance::ndf)
            add("/importance",
                "\"ndf\" draws charlie's normals near the horizon, where a sample weighs without "
                "bound; allowed: cosine, uniform");
    }

    void read_fresnel() {
        FresnelModel& fresnel = job_.fresnel;
        word(fresnel.model, "/fresnel/model");
        if (!problems_.sound("/fresnel/model")) return;
        for (const ColourField& field : kColourFields) {
            const std::string pointer = std::string("/fresnel/") + field.name;
            if (!given(pointer.c_str()) || !problems_.sound(pointer)) continue;
            if (!reads(field, fresnel.model)) {
                refuse_unread(field.name);
                continue;
            }
            fresnel.*field.numbers = numbers_of(document_["fresnel"][field.name]);
        }
        if (given("/fresnel/exponent") && problems_.sound("/fresnel/exponent")) {
            if (fresnel.model != Fresnel::schlick) refuse_unread("exponent");
            fresnel.exponent = document_["fresnel"]["exponent"].get<double>();
        }
        if (given("/fresnel/metal") && problems_.sound("/fresnel/metal")) {
            if (fresnel.model != Fresnel::conductor) refuse_unread("metal");
            fresnel.metal =
                from_word<Metal>(document_["fresnel"]["metal"].get_ref<const std::string&>());
        }
        if (fresnel.model == Fresnel::conductor) check_conductor();
        if (fresnel.model == Fresnel::edge_tint)
            for (const double value : fresnel.reflectivity)
                if (value > 0.99999)
                    add("/fresnel/reflectivity",
                        "no finite eta and k reflect more than 0.99999; a perfect mirror is the "
                        "model \"none\"");
    }

    void refuse_unread(const char* name) {
        add((std::string("/fresnel/") + name).c_str(),
            "is not read by model " + in_quotes(to_word(job_.fresnel.model)));
    }

    void check_conductor() {
        const FresnelModel& fresnel = job_.fresnel;
        const bool eta = given("/fresnel/eta"), k = given("/fresnel/k");
        if (fresnel.metal && (eta || k))
            add("/fresnel/metal",
                "has an eta and a k of its own; leave out either the metal or both numbers");
        if (!fresnel.metal && !given("/fresnel/metal") && (!eta || !k))
            add("/fresnel/model", "\"conductor\" needs eta and k, or a metal by name");
        if (!eta || !k || !problems_.sound("/fresnel/eta") || !problems_.sound("/fresnel/k"))
            return;
        for (std::size_t c = 0; c < 3; ++c) {
            const double n = fresnel.eta[fresnel.eta.size() == 3 ? c : 0];
            const double kk = fresnel.k[fresnel.k.size() == 3 ? c : 0];
            if (std::max(n, kk) >= 1e-4) continue;
            add("/fresnel/eta",
                "eta and k are both below 0.0001; the larger must be at least that");
            return;
        }
    }

    void read_diffuse() {
        word(job_.diffuse.model, "/diffuse/model");
        if (given("/diffuse/albedo") && problems_.sound("/diffuse/albedo"))
            job_.diffuse.albedo = numbers_of(document_["diffuse"]["albedo"]);
    }

    /// A walk over facets has an albedo, but no closed form at a pair of directions.
    void check_simulated() {
        if (!std::count(job_.quantities.begin(), job_.quantities.end(), Quantity::total_albedo))
            return;
        if (job_.coupling == Coupling::half_vector)
            add("/coupling",
                "\"half_vector\" weighs the diffuse lobe by F at each light's half vector, and "
                "\"ggx_lambert\" has no lobe but light that walks over facets; allowed: none, "
                "view");
        if (job_.distribution != Distribution::ggx || job_.masking != Masking::smith_correlated)
            add("/diffuse/model",
                "\"ggx_lambert\" walks over GGX facets under smith_correlated; the specular lobe "
                "of "
                "another surface cannot lie over it");
    }

    void check_together() {
        if (!problems_.sound("/quantities")) return;
        for (const Quantity quantity : job_.quantities) {
            const bool diffuse_alone = quantity == Quantity::diffuse_albedo ||
                                       quantity == Quantity::diffuse_average_albedo;
            if (diffuse_alone && job_.diffuse.model == DiffuseModel::none)
                add("/diffuse/model",
                    "\"none\" leaves " + in_quotes(to_word(quantity)) + " without a lobe");
        }
        if (job_.diffuse.model == DiffuseModel::ggx_lambert) check_simulated();
        if (job_.coupling == Coupling::kelemen && job_.diffuse.model > DiffuseModel::lambert)
            add("/coupling",
                "\"kelemen\" replaces the Lambert lobe; diffuse.model must be lambert");
        if (job_.coupling == Coupling::view && job_.multiscatter != Multiscatter::none)
            add("/multiscatter",
                "coupling \"view\" takes F out of the specular lobe, so that nothing is left to "
                "compensate by it; allowed: none");
    }

    const Json& document_;
    ProblemList& problems_;
    JobSpec& job_;
};

bool any_reads(const JobSpec& job, bool (*reading)(Quantity)) {
    return std::any_of(job.quantities.begin(), job.quantities.end(), reading);
}

Json fresnel_json(const FresnelModel& fresnel) {
    Json out = {{"model", to_word(fresnel.model)}};
    for (const ColourField& field : kColourFields) {
        const std::vector<double>& numbers = fresnel.*field.numbers;
        if (reads(field, fresnel.model) && !numbers.empty()) out[field.name] = to_json(numbers);
    }
    if (fresnel.model == Fresnel::schlick && fresnel.exponent != FresnelModel{}.exponent)
        out["exponent"] = fresnel.exponent;
    if (fresnel.model == Fresnel::conductor && fresnel.metal)
        out["metal"] = to_word(*fresnel.metal);
    return out;
}

}  // namespace

void read_models(const Json& document, ProblemList& problems, JobSpec& job) {
    Models(document, problems, job).read();
}

void write_models(const JobSpec& job, Json& document) {
    Json& microfacet = document["microfacet"];
    microfacet = {{"distribution", to_word(job.distribution)}, {"masking", to_word(job.masking)}};
    if (job.terminator_softening) microfacet["terminator_softening"] = true;
    document["importance"] = to_word(job.importance);
    document["fresnel"] = fresnel_json(job.fresnel);
    if (job.axes.size() == 3)
        document["fresnel"].erase(std::string(to_word(job.axes[2].parameter)));
    document["diffuse"] = {{"model", to_word(job.diffuse.model)},
                           {"albedo", to_json(job.diffuse.albedo)}};
    document["coupling"] = to_word(job.coupling);
    document["multiscatter"] = to_word(job.multiscatter);
    // What no quantity reads must not tell two jobs apart.
    const bool split = std::any_of(job.quantities.begin(), job.quantities.end(), [](Quantity q) {
        return q == Quantity::split_sum_scale || q == Quantity::split_sum_bias;
    });
    if (!any_reads(job, reads_fresnel)) {
        document["fresnel"] = {{"model", "schlick"}};
        if (split && job.fresnel.model == Fresnel::schlick &&
            job.fresnel.exponent != FresnelModel{}.exponent)
            document["fresnel"]["exponent"] = job.fresnel.exponent;
    }
    if (!any_reads(job, reads_diffuse)) document["diffuse"] = {{"model", "lambert"}};
    if (!any_reads(job, reads_multiscatter)) document["multiscatter"] = "none";
    if (std::find(job.quantities.begin(), job.quantities.end(), Quantity::total_albedo) ==
        job.quantities.end())
        document["coupling"] = "none";
}

}  // namespace kiln
