// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "server/compute/estimate.h"
#include "server/compute/plan.h"

namespace kiln {

/// Bound on the error of an estimate: 95 % of errors are smaller, rounding included.
inline double error_bound(const Estimate& estimate, Precision precision) {
    return kStudentT * estimate.standard_error() + rounding_floor(precision);
}

/// Whether fewer than 30 of an estimate's rare events are expected although they carry more than
/// `bound`: no claim of convergence holds then.
inline bool lacks_rare_events(const Estimate& estimate, double bound) {
    return estimate.missable > bound;
}

/// Whether a value at low roughness is not what it tends to as α → 0, by more than `bound` and the
/// leading order of what is missing: it cannot be trusted, whatever its standard error says.
bool misses_mirror_limit(const Pass& pass, const Share& share, std::size_t place,
                         const Estimate& estimate, double bound);

/// Whether so many samples of the hemisphere, cosine or uniform, are expected to meet the peak of
/// GGX or Beckmann at a place less than 30 times: what they missed is in no spread.
bool samples_miss_peak(const Pass& pass, std::size_t place, std::uint64_t samples);

}  // namespace kiln
