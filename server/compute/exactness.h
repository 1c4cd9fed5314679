// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "server/compute/backend.h"
#include "server/compute/engine.h"

namespace kiln {

/// Holds a finished table against quadrature, where the job's lobe has one: fills the report's
/// reference_* (of sampled jobs; quadrature's own error stands there already), reference_texels,
/// reconstruction_max and run_time_s.reference. Quantities without quadrature get an estimate of
/// reconstruction_max from the table. Takes all texels where that costs a tenth of the sampling or
/// the table is small, else a lattice of some thousand. Throws Cancelled.
void hold_against_quadrature(const JobSpec& job, Outcome& outcome, Backend& native,
                             const Control& control);

/// Exact values of the job's table by quadrature, every quantity of which has one (quadrature_lacks
/// in server/spec/channels.h), within `tolerance`. Throws Cancelled, Error("no_quadrature"), or
/// what the backend throws.
Table exact_table(const JobSpec& job, double tolerance, Backend& native, const Control& control);

}  // namespace kiln
