// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "server/compute/backend.h"
#include "server/compute/engine.h"
#include "server/compute/plan.h"
#include "server/compute/thread_pool.h"

namespace kiln {

/// Runs a job's plan on one backend. Fills table, standard errors on demand, and of the report:
/// error, trace, samples, replicates, work and run_time_s.integrate and .assemble. Throws
/// Cancelled, Error("non_finite"), or what the backend throws.
Outcome integrate(const JobSpec& job, const Plan& plan, Backend& backend, ThreadPool& pool,
                  const Control& control, bool standard_error_planes);

}  // namespace kiln
