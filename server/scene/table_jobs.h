// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

#include "server/scene/rules.h"
#include "server/scene/scene_plan.h"

namespace kiln {

/// The kinds of tables that a plan has.
enum class TableKind { specular, average, sheen, diffuse };

/// The job of one table over one piece of the roughness axis: nodes over the square root of NoV and
/// over roughness. `fixed`: the one reflectance of a table of one channel; compensated by the
/// options' multiscatter unless that is none.
JobSpec table_job(TableKind kind, const Range& piece, const PlanOptions& options,
                  const std::optional<rules::Reflectance>& fixed);

}  // namespace kiln
