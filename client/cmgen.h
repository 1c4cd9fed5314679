// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "server/spec/job_spec.h"
#include "server/study/study.h"

namespace kiln::client {

/// Adds Filament's cmgen to a convergence study of a table that it bakes, a square split sum under
/// GGX: a point of its diagrams, a row of its table and a note, or only a note where it is not
/// installed or fails. Its error is that of its own file from exact values at its own texels. True
/// of such a table.
bool add_cmgen(const JobSpec& job, Study& study);

}  // namespace kiln::client
