// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cmath>

#include "server/compute/backend.h"

namespace kiln {

/// 1 − E at low roughness, to leading order: α²(1 + NoV⁻²)/2, and averaged α²(ln(1/α) + 0.489). Too
/// large where NoV ≲ α. Under visible normals it is what the directions below the horizon carry.
inline double expected_deficit(const KernelMaterial& what, double NoV, double alpha) {
    if (what.averaged) return alpha > 0 ? alpha * alpha * (std::log(1 / alpha) + 0.489235) : 0;
    return alpha * alpha * (1 + 1 / (NoV * NoV)) / 2;
}

/// Replicates that saw none of an integral's rare events agree with each other, and their spread
/// knows nothing of what all of them missed. Where fewer than three are expected among `samples`,
/// one event more or less, of weight 1, belongs to the variance of the mean. At α = 0 there are
/// none.
inline double rare_event_variance(double deficit, double samples) {
    constexpr double kEventsSeen = 3;  // 95 % of such sets see at least one (Poisson)
    if (!(deficit > 0) || deficit * samples >= kEventsSeen) return 0;
    return 1 / (samples * samples);
}

}  // namespace kiln
