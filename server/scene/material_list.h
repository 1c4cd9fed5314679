// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <nlohmann/json_fwd.hpp>

#include "server/scene/scene.h"
#include "server/spec/schema.h"

namespace kiln {

/// The contract's Scene: materials with their lobes and ranges, for pipelines that know them
/// without glTF.
SceneUse read_material_list(const nlohmann::json& document, ProblemList& problems);

}  // namespace kiln
