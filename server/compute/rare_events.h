// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <cmath>

#include "server/compute/backend.h"
#include "server/spec/deficit.h"

namespace kiln {

/// expected_deficit, or its average, of a kernel's lobe.
inline double expected_deficit(const KernelMaterial& what, double NoV, double alpha) {
    return what.averaged ? expected_average_deficit(alpha)
                         : expected_deficit(static_cast<Masking>(what.masking), NoV, alpha);
}

/// The mean square of what a visible normal loses, 1 − G2 / G1 above the horizon and 1 below, as if
/// it were a chance of losing all. Where α ≪ NoV that is 1 − E. Where NoV ≪ α most of 1 − E is a
/// little of every normal's, and the rest is rare: light below an elevation z has the chance α z' +
/// z'² / 8α² with z' = z + NoV, by slopes about 1 and about α, and loses NoV / z' under correlated
/// masking. The logarithm ends near z' = α / 4 by sums over 2^22 normals: within 4 % of this where
/// NoV < α / 9, a fifth below it at α / 3.
inline double lost_chance(const KernelMaterial& what, double NoV, double alpha) {
    const double expected = expected_deficit(what, NoV, alpha);
    if (what.averaged || what.masking != static_cast<int>(Masking::smith_correlated) || !(NoV > 0))
        return expected;
    const double part = NoV / (2 * alpha);
    return std::min(expected,
                    2 * alpha * NoV + part * part * (0.5 + std::log1p(alpha / (4 * NoV))));
}

/// The VoH at which light is lost, in the mean over the visible normals that lose it below the
/// horizon or to masking: from 0.4 to 0.8 α where NoV ≪ α and 0.45 to 0.67 NoV where α ≪ NoV, by a
/// sum over such normals. Estimates have no bias whatever it is.
inline double lost_VoH(double NoV, double alpha) {
    return std::min(std::hypot(0.65 * NoV, 0.6 * alpha), 1.0);
}

/// Samples that hold fewer rare events than this say too little about them.
inline constexpr double kRareEventsSeen = 30;

/// Replicates that saw none of an integral's rare events agree with each other, and their spread
/// knows nothing of what all of them missed. Where fewer than three are expected among all samples
/// (95 % of such sets see at least one), the variance of their number, `rare`, adds to the spread.
/// From there on the spread has it on average, but not often enough: of `events` in 16 replicates,
/// Student's interval holds 95 % - 0.24 / events (Hall 1992, eq. 2.56, with the skewness and
/// kurtosis of Poisson's distribution); so it is no less than `rare` below the 8 events that
/// leave it 92 %.
inline double with_rare_events(double spread, double rare, double events) {
    constexpr double kEventsUnseen = 3, kEventsSkewed = 8;
    if (events < kEventsUnseen) return spread + rare;
    return events < kEventsSkewed ? std::max(spread, rare) : spread;
}

}  // namespace kiln
