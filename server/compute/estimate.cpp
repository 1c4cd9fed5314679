// SPDX-License-Identifier: Apache-2.0
#include "server/compute/estimate.h"

#include <cmath>

#include "server/compute/rare_events.h"

namespace kiln {

namespace {
constexpr std::size_t kMirroredTerms[] = {kSchlick, kColour, kColour + 1, kColour + 2};
constexpr std::size_t kPlacesATask = 512;

/// Chance of half vectors so far from the normal that a Fresnel term is another one. For NoV ≪ 1 it
/// is ∫ (5 t)² p dt over tangents t up to 1, of density p = 2 α² / (π NoV t²).
double tilted_chance(const KernelMaterial& what, double NoV, double alpha) {
    return std::min(expected_deficit(what, NoV, alpha), 5 * alpha * alpha / std::max(NoV, alpha));
}

/// Visible normals rarely meet directions below the horizon, where no term is more than 1, or those
/// that a Fresnel term depends on.
void add_deficit_events(const Pass& pass, const Mean& mean, std::size_t place, double& chance,
                        double& weight) {
    const double NoV = pass.places.NoV(place), alpha = pass.places.alpha(place);
    bool tilted = false;
    for (const std::size_t t : kMirroredTerms) tilted |= mean.terms[t] != 0;
    for (const double coefficient : mean.terms) weight = std::max(weight, std::abs(coefficient));
    if (!(alpha > 0))
        chance = 0;
    else if (tilted && !pass.what.material.averaged)
        chance = tilted_chance(pass.what.material, NoV, alpha);
    else
        chance = lost_chance(pass.what.material, NoV, alpha);
}

/// Beside log-uniform tangents the tilted ones alone are left: VoH between NoV / 2, towards the
/// horizon, and 1.
void add_tilted_events(const Pass& pass, const Mean& mean, std::size_t place, double& control,
                       double& chance, double& weight) {
    const double NoV = pass.places.NoV(place), alpha = pass.places.alpha(place);
    for (const std::size_t t : kMirroredTerms) {
        const double coefficient = mean.mirrored[t];
        if (coefficient == 0) continue;
        const double lost = pass.mirror(t, lost_VoH(NoV, alpha));
        control += coefficient * lost;
        weight += std::abs(coefficient) * std::max(std::abs(pass.mirror(t, NoV / 2) - lost),
                                                   std::abs(pass.mirror(t, 1) - lost));
    }
    chance = tilted_chance(pass.what.material, NoV, alpha);
}
/// Visible lights are dense towards the horizon: of a chance p, √p are tilted, of weight 2 √p.
void add_visible_light_events(const Pass& pass, const Mean& mean, std::size_t place, double& chance,
                              double& weight) {
    const double NoV = pass.places.NoV(place), alpha = pass.places.alpha(place);
    chance = std::sqrt(tilted_chance(pass.what.material, NoV, alpha));
    for (const std::size_t t : kMirroredTerms) weight += std::abs(mean.terms[t]) * 2 * chance;
}
}  // namespace

Means::Means(const std::vector<Share>& shares, const Region& region) {
    for (const Share& share : shares) {
        OfShare found{index(share.a, region), 0, 0};
        found.b = found.both = found.a;
        if (terms_of(share.b) != 0) {
            found.b = index(share.b, region);
            Combination sum = share.a;
            for (std::size_t t = 0; t < kTermCount; ++t) sum[t] += share.b[t];
            found.both = index(sum, region);
        }
        shares_.push_back(found);
    }
}

std::size_t Means::index(const Combination& combination, const Region& region) {
    Mean mean{combination, 0, {}};
    Combination& c = mean.terms;
    if (region.deficit_apart) {
        mean.constant = c[kWeight];  // E = 1 − D
        c[kDeficit] -= c[kWeight];
        c[kWeight] = 0;
        for (const std::size_t t : kMirroredTerms)
            if (!(region.parted_terms >> t & 1)) mean.mirrored[t] = c[t];
    }
    const auto at = std::find(list_.begin(), list_.end(), mean);
    if (at != list_.end()) return static_cast<std::size_t>(at - list_.begin());
    list_.push_back(mean);
    return list_.size() - 1;
}

PlaceFacts Means::facts(const Pass& pass, const Region& region, ThreadPool& pool,
                        std::span<const std::uint32_t> places) const {
    PlaceFacts facts;
    facts.place_count = places.size();
    for (auto* planes : {&facts.controls, &facts.event_chances, &facts.event_weights})
        planes->resize(list_.size());
    const PointKind first = region.draws[0].points;
    const bool lights = first == PointKind::visible_lights || first == PointKind::parted_lights;
    if (pass.points != PointKind::visible_normals) return facts;
    for (std::size_t m = 0; m < list_.size(); ++m) {
        const bool tilted = terms_of(list_[m].mirrored) != 0;
        if (region.deficit_apart && !tilted) continue;
        facts.event_chances[m].resize(places.size());
        facts.event_weights[m].resize(places.size());
        if (tilted) facts.controls[m].resize(places.size());
        pool.parallel_for((places.size() + kPlacesATask - 1) / kPlacesATask, [&](std::size_t task) {
            const std::size_t end = std::min((task + 1) * kPlacesATask, places.size());
            for (std::size_t i = task * kPlacesATask; i < end; ++i) {
                double &chance = facts.event_chances[m][i], &weight = facts.event_weights[m][i];
                if (lights)
                    add_visible_light_events(pass, list_[m], places[i], chance, weight);
                else if (tilted)
                    add_tilted_events(pass, list_[m], places[i], facts.controls[m][i], chance,
                                      weight);
                else
                    add_deficit_events(pass, list_[m], places[i], chance, weight);
            }
        });
    }
    return facts;
}

}  // namespace kiln
