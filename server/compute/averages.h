// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "server/compute/backend.h"
#include "server/compute/engine.h"
#include "server/compute/plan.h"

namespace kiln {

/// 1 − E_avg of a job's lobe at each place of Places::averaged(job), for what compensates the
/// energy that single scattering loses: by quadrature.
Averages average_deficits(const JobSpec& job, Backend& native, const Control& control);

}  // namespace kiln
