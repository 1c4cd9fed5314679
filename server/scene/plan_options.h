// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <map>
#include <string>

#include "server/scene/scene_plan.h"

namespace kiln {

struct PlanRequest {
    SceneChoice choice;
    PlanOptions options;
};

/// Options as text by name (the contract's PlanOptions), with its defaults for what is left out.
/// Throws Error("bad_query") naming the option that is unknown, out of range, or at odds with
/// another.
PlanRequest read_plan_request(const std::map<std::string, std::string>& options);

}  // namespace kiln
