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
double tilted_chance(double NoV, double alpha) { return 5 * alpha * alpha / std::max(NoV, alpha); }

/// What a lost light takes from a mean of these terms, by its VoH.
LostLights lost_lights(const Pass& pass, const Combination& terms) {
    return LostLights([&](double VoH) {
        double value = -terms[kDeficit];
        for (std::size_t t = 0; t < kTermCount; ++t)
            if (terms[t] != 0) value += terms[t] * pass.mirror(t, VoH);
        return value;
    });
}

/// The rare events of visible normals at the places of a pass, in one mean.
class NormalEvents {
  public:
    NormalEvents(const Pass& pass, const Mean& mean)
        : pass_(pass),
          mean_(mean),
          beside_deficit_(terms_of(mean.mirrored) != 0),
          lost_(lost_lights(pass, beside_deficit_ ? mean.mirrored : mean.terms)) {
        for (const std::size_t t : kMirroredTerms)
            tilted_ |= mean.terms[t] != 0 && !pass.what.material.averaged;
    }

    /// And the control, which log-uniform tangents beside visible normals take.
    RareEvents at(std::size_t place, double& control) const {
        const double NoV = pass_.places.NoV(place), alpha = pass_.places.alpha(place);
        return beside_deficit_ ? beside_deficit(NoV, alpha, control) : alone(NoV, alpha);
    }

  private:
    /// Directions below the horizon, where no term is more than 1, or those that a Fresnel term
    /// depends on.
    RareEvents alone(double NoV, double alpha) const {
        double weight = 0;
        for (const double coefficient : mean_.terms)
            weight = std::max(weight, std::abs(coefficient));
        return alpha > 0 ? events(NoV, alpha, 0, weight) : RareEvents{};
    }

    /// Beside log-uniform tangents the tilted ones alone are left: VoH between NoV / 2, towards the
    /// horizon, and 1.
    RareEvents beside_deficit(double NoV, double alpha, double& control) const {
        double weight = 0;
        for (const std::size_t t : kMirroredTerms) {
            const double coefficient = mean_.mirrored[t];
            if (coefficient == 0) continue;
            const double lost = pass_.mirror(t, lost_VoH(NoV, alpha));
            control += coefficient * lost;
            weight += std::abs(coefficient) * std::max(std::abs(pass_.mirror(t, NoV / 2) - lost),
                                                       std::abs(pass_.mirror(t, 1) - lost));
        }
        return events(NoV, alpha, control, weight);
    }

    /// `weight`: at most, of any but lost lights.
    RareEvents events(double NoV, double alpha, double control, double weight) const {
        const KernelMaterial& what = pass_.what.material;
        const double lost = expected_deficit(what, NoV, alpha);
        if (tilted_ && tilted_chance(NoV, alpha) < lost) return {tilted_chance(NoV, alpha), weight};
        const bool by_few = !what.averaged && 0 < NoV && NoV < alpha &&
                            what.masking == static_cast<int>(Masking::smith_correlated);
        return by_few ? lost_.at(NoV, alpha, control) : RareEvents{lost, weight};
    }

    const Pass& pass_;
    const Mean& mean_;
    const bool beside_deficit_;
    bool tilted_ = false;
    const LostLights lost_;
};

/// Visible lights are dense towards the horizon: of a chance p, √p are tilted, of weight 2 √p.
RareEvents visible_light_events(const Pass& pass, const Mean& mean, std::size_t place) {
    const double NoV = pass.places.NoV(place), alpha = pass.places.alpha(place);
    const double chance = std::sqrt(
        std::min(expected_deficit(pass.what.material, NoV, alpha), tilted_chance(NoV, alpha)));
    double weight = 0;
    for (const std::size_t t : kMirroredTerms) weight += std::abs(mean.terms[t]) * 2 * chance;
    return {chance, weight};
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
        const NormalEvents normals(pass, list_[m]);
        pool.parallel_for((places.size() + kPlacesATask - 1) / kPlacesATask, [&](std::size_t task) {
            const std::size_t end = std::min((task + 1) * kPlacesATask, places.size());
            for (std::size_t i = task * kPlacesATask; i < end; ++i) {
                double control = 0;
                const RareEvents events = lights ? visible_light_events(pass, list_[m], places[i])
                                                 : normals.at(places[i], control);
                facts.event_chances[m][i] = events.chance;
                facts.event_weights[m][i] = events.weight;
                if (tilted) facts.controls[m][i] = control;
            }
        });
    }
    return facts;
}

}  // namespace kiln
