// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <cmath>

#include "server/compute/backend.h"

namespace kiln {

/// 1 − E of a GGX lobe to the leading order of either end: α²(1 + NoV⁻²)/2 where α ≪ NoV, under
/// correlated masking NoV (0.21/α + 9 α) where NoV ≪ α; averaged α²(ln(1/α) + 0.489). Right within
/// a factor of two where it is below 0.01, too large where NoV ≈ α. Under visible normals it is the
/// probability of the directions below the horizon, nearly.
inline double expected_deficit(const KernelMaterial& what, double NoV, double alpha) {
    if (!(alpha > 0)) return 0;
    if (what.averaged) return alpha * alpha * (std::log(1 / alpha) + 0.489235);
    const double steep = alpha * alpha * (1 + 1 / (NoV * NoV)) / 2;
    if (static_cast<Masking>(what.masking) != Masking::smith_correlated) return steep;
    return std::min(steep, NoV * (0.21 / alpha + 9 * alpha));
}

/// Samples that hold fewer rare events than this say too little about them.
inline constexpr double kRareEventsSeen = 30;

/// Replicates that saw none of an integral's rare events agree with each other, and their spread
/// knows nothing of what all of them missed. Where fewer than three are expected among `samples`
/// (95 % of such sets see at least one), their number's own variance belongs to that of the mean:
/// each weighs 1.
inline double rare_event_variance(double deficit, double samples) {
    constexpr double kEventsExpected = 3;
    return deficit * samples < kEventsExpected ? deficit / samples : 0;
}

}  // namespace kiln
