// SPDX-License-Identifier: Apache-2.0
#include "server/compute/estimate.h"

#include <cmath>

#include "server/compute/rare_events.h"

namespace kiln {

namespace {
constexpr std::size_t kMirroredTerms[] = {kSchlick, kColour, kColour + 1, kColour + 2};
constexpr int kRareTerms = 1 << kWeight | 1 << kSchlick | 1 << kDeficit | 7 << kColour;
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
    Mean mean{combination, 0, {}, 0};
    Combination& c = mean.terms;
    const bool is_diffuse = (terms_of(c) & kRareTerms) == 0;
    if (region.log_tangents) {
        mean.constant = c[kWeight];  // E = 1 − D
        c[kDeficit] -= c[kWeight];
        c[kWeight] = 0;
        for (const std::size_t t : kMirroredTerms) mean.mirrored[t] = c[t];
    } else if (!is_diffuse) {
        // Below the horizon neither F nor (1 − VoH)^n is more than 1.
        for (std::size_t t = 0; t < kTermCount; ++t)
            mean.rare_weight = std::max(mean.rare_weight, std::abs(c[t]));
    }
    const auto at = std::find(list_.begin(), list_.end(), mean);
    if (at != list_.end()) return static_cast<std::size_t>(at - list_.begin());
    list_.push_back(mean);
    return list_.size() - 1;
}

PlaceFacts Means::facts(const Pass& pass, const Region& region,
                        std::span<const std::uint32_t> places) const {
    PlaceFacts facts;
    const bool visible = pass.points == PointKind::visible_normals && !region.log_tangents;
    for (const std::uint32_t place : places)
        facts.deficits.push_back(visible ? expected_deficit(pass.what.material,
                                                            pass.places.NoV(place),
                                                            pass.places.alpha(place))
                                         : 0);
    facts.controls.resize(list_.size());
    for (std::size_t m = 0; m < list_.size(); ++m) {
        if (terms_of(list_[m].mirrored) == 0) continue;
        for (const std::uint32_t place : places) {
            double control = 0;
            for (const std::size_t t : kMirroredTerms)
                if (list_[m].mirrored[t] != 0)
                    control += list_[m].mirrored[t] * pass.mirror(t, pass.places.NoV(place));
            facts.controls[m].push_back(control);
        }
    }
    return facts;
}

}  // namespace kiln
