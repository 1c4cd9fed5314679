// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <cmath>

#include "server/spec/job_spec.h"

namespace kiln {

/// 1 − E of a GGX lobe to the leading order of either end: α²(1 + NoV⁻²)/2 where α ≪ NoV, under
/// correlated masking NoV (0.21/α + 9 α) where NoV ≪ α. Right within a factor of two where it is
/// below 0.01, too large where NoV ≈ α. Under visible normals it is the probability of the
/// directions below the horizon, nearly.
inline double expected_deficit(Masking masking, double NoV, double alpha) {
    if (!(alpha > 0)) return 0;
    const double steep = alpha * alpha * (1 + 1 / (NoV * NoV)) / 2;
    if (masking != Masking::smith_correlated) return steep;
    return std::min(steep, NoV * (0.21 / alpha + 9 * alpha));
}

/// The same averaged over NoV: α²(ln(1/α) + 0.489).
inline double expected_average_deficit(double alpha) {
    if (!(alpha > 0)) return 0;
    return alpha * alpha * (std::log(1 / alpha) + 0.489235);
}

/// Where a draw of its own has the smaller error of 1 − E at equal samples: measured against
/// quadrature over NoV in [1e-6, 1], α in [1e-6, 1], log-uniform tangents are even at 1 − E of
/// 0.01, ahead 20 times at 2e-4; of an average, horizon normals are all but even at 0.04, ahead 7
/// to 12 times at 0.002. Of fewer than some 15 events in 1024 visible normals
/// the spread of replicates says too little. Below α = 1e-8 squares of the half vector's parts
/// would leave the range of a float; 1 − E is below 1e-16 / NoV² there.
inline bool better_apart(double alpha, double expected, bool averaged) {
    constexpr double kAlphaLeast = 1e-8, kDeficitMost = 0.015, kAveragedDeficitMost = 0.03;
    return alpha >= kAlphaLeast && expected < (averaged ? kAveragedDeficitMost : kDeficitMost);
}

}  // namespace kiln
