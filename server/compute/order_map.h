// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <vector>

#include "server/compute/plan.h"
#include "server/compute/quadrature.h"

namespace kiln {

/// The order that each place of a table takes, and what it is off by.
struct OrderMap {
    std::vector<std::uint8_t> step;  ///< in kQuadratureSteps
    std::vector<float> error;        ///< an estimate
    std::uint64_t evaluations = 0;
    std::size_t unsettled = 0;  ///< places whose error is above the tolerance
};

/// Some hundred places, dense at the edges, are raised until two orders agree; every place takes
/// the highest order that one of the four around it needs. An error four times below the tolerance
/// lets the lower order do. `places` are those of a table of two axes, which job says how to
/// divide.
OrderMap make_order_map(const JobSpec& job, const Places& places, const QuadratureKind& kind,
                        const QuadratureParameters& parameters,
                        const QuadratureTolerance& tolerance, Backend& backend);

}  // namespace kiln
