// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "server/compute/backend.h"
#include "server/compute/engine.h"
#include "server/compute/plan.h"

namespace kiln {

/// Runs a job's plan by quadrature instead of sampling (integrator "quadrature"): within 1e-9 in
/// double, 1e-6 in float. Fills the table, and of the report error (reference_*: the difference of
/// the last two orders), samples, work, status and run_time_s.integrate. The gate lets only plans
/// through that stay on the fast path. Throws Cancelled, or what the backend throws.
Outcome integrate_by_quadrature(const JobSpec& job, const Plan& plan, Backend& backend,
                                const Control& control);

}  // namespace kiln
