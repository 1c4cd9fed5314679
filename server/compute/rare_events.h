// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "server/compute/backend.h"
#include "server/spec/deficit.h"

namespace kiln {

/// expected_deficit, or its average, of a kernel's lobe.
inline double expected_deficit(const KernelMaterial& what, double NoV, double alpha) {
    return what.averaged ? expected_average_deficit(alpha)
                         : expected_deficit(static_cast<Masking>(what.masking), NoV, alpha);
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
