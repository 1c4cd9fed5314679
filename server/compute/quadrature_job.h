// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <vector>

#include "server/compute/backend.h"
#include "server/compute/engine.h"
#include "server/compute/plan.h"
#include "server/compute/thread_pool.h"

namespace kiln {

/// What the quadrature of a plan launches: nothing for ggx_lambert, which is solved on the host.
std::vector<KernelKind> quadrature_kernels(const JobSpec& job, const Plan& plan);

/// Runs a job's plan by quadrature instead of sampling (integrator "quadrature"), within
/// `tolerance`: 1e-9 in double and 1e-6 in float are within reach. Fills the table, and of the
/// report error (reference_*: the difference of the last two orders), samples, work, status and
/// run_time_s.integrate. The gate lets only plans through that quadrature has a rule for. Throws
/// Cancelled, or what the backend throws.
Outcome integrate_by_quadrature(const JobSpec& job, const Plan& plan, Backend& backend,
                                ThreadPool& pool, double tolerance, const Control& control);

/// Of E, B and their like, where a job says nothing else.
inline constexpr double kQuadratureTolerance = 1e-9;

}  // namespace kiln
