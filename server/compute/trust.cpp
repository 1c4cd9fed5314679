// SPDX-License-Identifier: Apache-2.0
#include "server/compute/trust.h"

#include <algorithm>
#include <cmath>

#include "server/compute/rare_events.h"

namespace kiln {

namespace {

constexpr int kKnownTerms = 1 << kWeight | 1 << kSchlick | 1 << kDeficit;

bool has_mirror_limit(const Pass& pass, const Share& share) {
    const KernelMaterial& what = pass.what.material;
    return !share.part && (terms_of(share.a) & ~kKnownTerms) == 0 &&
           static_cast<Distribution>(what.distribution) == Distribution::ggx &&
           static_cast<Masking>(what.masking) <= Masking::smith_separable;
}

}  // namespace

// For α below 0.02 and NoV above 2 α, 1 − E is within a factor of two of its leading order and B
// within 11 times that of (1 − NoV)^n: seen against quadrature.
bool misses_mirror_limit(const Pass& pass, const Share& share, std::size_t place,
                         const Estimate& estimate, double bound) {
    const KernelMaterial& what = pass.what.material;
    const double alpha = pass.places.alpha(place), NoV = pass.places.NoV(place);
    if (!has_mirror_limit(pass, share) || !(alpha < 0.02)) return false;
    if (what.averaged ? share.a[kSchlick] != 0 : !(NoV > 2 * alpha)) return false;
    const double deficit = expected_deficit(what, NoV, alpha);
    double limit = 0, off = 0;
    for (std::size_t t = 0; t < kTermCount; ++t) {
        if (share.a[t] == 0) continue;
        limit += share.a[t] * pass.mirror(t, NoV);
        off += std::abs(share.a[t]) * deficit * (t == kSchlick ? 22 : 2);
    }
    const double difference = std::abs(estimate.value - limit);
    if (difference > off + bound) return true;
    const double lacking = share.a[kDeficit] - share.a[kWeight];
    return share.a[kSchlick] == 0 && difference + bound < std::abs(lacking) * deficit / 2;
}

// Half of all normals of GGX, 1 - 1/e of Beckmann's, lie within tan θ = α, π α² of solid angle;
// they mirror the view into 4 V·h times that, about a light with NoL = NoV. At grazing views both
// cosines are those of the lobe's own width, and an average weighs NoV by itself: 2/3 in the mean.
bool samples_miss_peak(const Pass& pass, std::size_t place, std::uint64_t samples) {
    const KernelMaterial& what = pass.what.material;
    const auto importance = static_cast<Importance>(what.importance);
    const bool blind = importance == Importance::cosine || importance == Importance::uniform;
    const bool peaked = static_cast<Distribution>(what.distribution) != Distribution::charlie;
    if (pass.lobe != Lobe::microfacet || !blind || !peaked) return false;
    const double alpha = pass.places.alpha(place);
    const double cosine = what.averaged ? 2.0 / 3 : std::max(pass.places.NoV(place), alpha);
    const double density = importance == Importance::cosine ? cosine : 0.5;  // times π
    return static_cast<double>(samples) * 4 * cosine * alpha * alpha * density < kRareEventsSeen;
}

}  // namespace kiln
