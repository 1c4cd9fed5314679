// SPDX-License-Identifier: Apache-2.0
#include "server/study/furnace_reasons.h"

#include <algorithm>

#include "server/compute/fresnel.h"
#include "server/spec/contract.h"
#include "server/spec/words.h"

namespace kiln {

namespace {

constexpr int kColours = 3;

/// Whether F of some colour, beside its F at normal incidence, is as `wanted` says at some cosine.
bool any_fresnel(const JobSpec& job, const auto& wanted) {
    constexpr int kSteps = 1000;
    for (int colour = 0; colour < kColours; ++colour) {
        const double normal = fresnel(job.fresnel, colour, 1);
        for (int i = 0; i <= kSteps; ++i)
            if (wanted(fresnel(job.fresnel, colour, static_cast<double>(i) / kSteps), normal))
                return true;
    }
    return false;
}

bool reflects(const JobSpec& job) {
    return any_fresnel(job, [](double F, double) { return F != 0; });
}

/// Whether the model's own lobe is in f(V, L) at all.
bool has_own_diffuse(const JobSpec& job) {
    const auto& albedo = job.diffuse.albedo;
    const bool black = std::all_of(albedo.begin(), albedo.end(), [](double a) { return a == 0; });
    const bool covered =
        (job.coupling == Coupling::view || job.coupling == Coupling::half_vector) &&
        !any_fresnel(job, [](double F, double) { return F != 1; });
    return job.diffuse.model != DiffuseModel::none && job.coupling != Coupling::kelemen && !black &&
           !covered;
}

std::string as_published(const JobSpec& job, const char* what) {
    return std::string(to_word(job.diffuse.model)) + ' ' + what + " as published";
}

}  // namespace

Quantity specular_quantity(const JobSpec& job) {
    // Under `view` F stands outside of the lobe.
    return job.coupling == Coupling::view ? Quantity::directional_albedo
                                          : Quantity::compensated_albedo;
}

Reasons known_excess(const JobSpec& job, const Excess& most) {
    Reasons reasons;
    if (most.specular > 1 && reflects(job)) {
        if (job.distribution == Distribution::charlie)
            reasons.emplace_back("Charlie's lobe exceeds 1 as published");
        if (job.masking == Masking::karis_ibl || job.masking == Masking::karis_direct ||
            job.masking == Masking::unreal_joint)
            reasons.emplace_back("the masking is an approximation");
    }
    if (most.diffuse > 1 && job.coupling != Coupling::kelemen &&
        known_of(job.diffuse.model).exceeds_one)
        reasons.push_back(as_published(job, "exceeds 1"));
    // A coupling adds to it where the material returns more than its diffuse lobe alone.
    if (most.diffuse > 0 && most.added > 0 && reflects(job)) {
        if (job.coupling == Coupling::none)
            reasons.emplace_back(
                "nothing takes from the diffuse lobe what the specular one reflects");
        if (job.coupling == Coupling::half_vector)
            reasons.emplace_back(
                "F(VoH) depends on the light, so the two lobes do not share what there is");
    }
    return reasons;
}

Reasons known_asymmetry(const JobSpec& job) {
    Reasons reasons;
    if (job.coupling == Coupling::view &&
        any_fresnel(job, [](double F, double normal) { return F != normal; }))
        reasons.emplace_back("F(NoV) stands without its like for L");
    if (job.multiscatter == Multiscatter::turquin && reflects(job))
        reasons.emplace_back("Turquin's factor depends on V alone");
    if (job.terminator_softening && reflects(job))
        reasons.emplace_back("the softening changes the light's term alone");
    if (has_own_diffuse(job) && known_of(job.diffuse.model).not_reciprocal)
        reasons.push_back(as_published(job, "is not reciprocal"));
    return reasons;
}

Reasons known_negative(const JobSpec& job) {
    Reasons reasons;
    if (job.fresnel.model == Fresnel::f82_tint &&
        any_fresnel(job, [](double F, double) { return F < 0; }))
        reasons.emplace_back("F82's formula is negative there");
    if (has_own_diffuse(job) && known_of(job.diffuse.model).negative)
        reasons.push_back(as_published(job, "is negative at some pairs"));
    if (job.distribution == Distribution::charlie && reflects(job) &&
        (job.multiscatter != Multiscatter::none ||
         (job.coupling == Coupling::kelemen && job.diffuse.model != DiffuseModel::none)))
        reasons.emplace_back(
            "1 - E, of which the added lobe is made, is negative where Charlie's exceeds 1");
    return reasons;
}

std::string because(const Reasons& why) {
    std::string all;
    for (const std::string& reason : why) all += (all.empty() ? " (" : "; ") + reason;
    return all.empty() ? "" : all + ")";
}

}  // namespace kiln
