// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

#include "server/spec/job_spec.h"

// Why a material as published fails a verdict of the furnace study: every reason that is known and
// at work in this job. None: the program or the job's model is wrong.
namespace kiln {

using Reasons = std::vector<std::string>;

/// Albedos at most of all places at which the material exceeds 1.
struct Excess {
    double specular = 0;  ///< of specular_quantity()
    double diffuse = 0;   ///< of the diffuse lobe alone
    double added = 0;     ///< of both, less the diffuse lobe alone
};

/// The albedo that stands for the specular lobe alone.
Quantity specular_quantity(const JobSpec& job);

Reasons known_excess(const JobSpec& job, const Excess& most);
Reasons known_asymmetry(const JobSpec& job);
Reasons known_negative(const JobSpec& job);

/// " (one; another)", or "".
std::string because(const Reasons& why);

}  // namespace kiln
