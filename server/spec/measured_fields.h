// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <nlohmann/json_fwd.hpp>

#include "server/spec/job_spec.h"
#include "server/spec/schema.h"

namespace kiln {

/// Reads `measured` and the resolution of a slice of a walked document into `job`, and adds what
/// makes no sense to `problems`. `given` is the document as it came.
void read_measured(const nlohmann::json& given, const nlohmann::json& document,
                   ProblemList& problems, JobSpec& job);

/// The one spelling of a job's `measured`: a list with everything said of each material, and what
/// the kind reads.
nlohmann::json measured_json(const JobSpec& job);

}  // namespace kiln
