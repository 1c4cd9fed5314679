// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <vector>

#include "server/compute/engine.h"
#include "server/spec/job_spec.h"

namespace kiln {

/// What a job sets, beside the defaults, and nothing in it reads.
std::vector<LeftOut> unread_fields(const JobSpec& job);

}  // namespace kiln
