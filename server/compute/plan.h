// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <vector>

#include "server/compute/axes.h"
#include "server/compute/backend.h"
#include "server/compute/report.h"
#include "server/spec/job_spec.h"

namespace kiln {

/// One kernel specialisation over one set of places: the quantities that share it cost its terms
/// once.
struct Pass {
    Specialisation what;
    Places places;
    std::vector<std::size_t> channels;  ///< of the table
};

/// What is computed for a job, and what is not.
struct Plan {
    std::vector<Pass> passes;
    std::vector<LeftOut> left_out;
};

Plan make_plan(const JobSpec& job);

}  // namespace kiln
