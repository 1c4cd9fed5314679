// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

#include "server/scene/scene_plan.h"

namespace kiln {

/// Atlases of these measurements (ids, each once): one, or as few as jobs may be large. The order
/// of their cells is that of the ids, so that neither a material's name nor its place in the scene
/// makes another job.
std::vector<JobSpec> atlas_jobs(std::vector<std::string> ids, const PlanOptions& options);

/// Texture coordinate = scale · angle + offset, in an atlas of angles in radians.
struct AngleLookup {
    double scale = 0, offset = 0;
};

/// Where a shader finds one slice of a cell, in texture coordinates.
struct SliceLookup {
    double theta_in = 0;  ///< degrees
    AngleLookup phi_d, theta_d;
};
std::vector<SliceLookup> slice_lookups(const JobSpec& atlas, std::size_t cell);

}  // namespace kiln
