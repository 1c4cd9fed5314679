// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>

#include "server/spec/job_spec.h"
#include "server/study/study.h"

namespace kiln::client {

/// Adds Filament's cmgen to a convergence study as a point of its diagrams and a row of its table,
/// where it is installed and bakes such a table: a square split sum under GGX. Its error is that of
/// its own file from exact values at its own texels. True where something was added.
bool add_cmgen(const JobSpec& job, Study& study);

}  // namespace kiln::client
