// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "server/compute/backend.h"
#include "server/compute/engine.h"
#include "server/compute/plan.h"
#include "server/compute/thread_pool.h"

namespace kiln {

/// 1 − E_avg of a job's lobe at each place of Places::averaged(job), for what compensates the
/// energy that single scattering loses: by quadrature where that is cheap or the job asks for it,
/// else by sampling in double.
Averages average_deficits(const JobSpec& job, Backend& native, ThreadPool& pool,
                          const Control& control);
/// The same by quadrature, of any lobe.
Averages exact_average_deficits(const JobSpec& job, Backend& native, const Control& control);

}  // namespace kiln
