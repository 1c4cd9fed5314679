// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <nlohmann/json_fwd.hpp>

#include "server/spec/job_spec.h"
#include "server/spec/schema.h"

namespace kiln {

/// Reads the lobe, Fresnel, diffuse, coupling and multiscatter fields of a walked document into
/// `job`, with the defaults that depend on other fields, and adds what makes no sense together to
/// `problems`. Quantities are read already.
void read_models(const nlohmann::json& document, ProblemList& problems, JobSpec& job);

/// The same fields of the canonical document: what a model reads and nothing else.
void write_models(const JobSpec& job, nlohmann::json& document);

}  // namespace kiln
