// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "server/compute/estimate.h"
#include "server/compute/plan.h"

namespace kiln {

/// Bound on the error of an estimate: 95 % of errors are smaller, rounding included.
inline double error_bound(const Estimate& estimate, Precision precision) {
    return kStudentT * estimate.standard_error() + rounding_floor(precision);
}

/// Whether an estimate cannot be trusted, whatever its standard error says: fewer than 30 of its
/// rare events are expected and they carry more than `bound`; or at low roughness the value is not
/// what it tends to as α → 0, by more than `bound` and the leading order of what is missing.
bool is_suspect(const Pass& pass, const Share& share, std::size_t place, const Estimate& estimate,
                double bound);

}  // namespace kiln
