// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <vector>

#include "server/compute/table.h"
#include "server/scene/scene_plan.h"
#include "server/scene/table_jobs.h"

namespace kiln::client {

/// A table as it was baked, with the job that says where its texels lie.
struct BakedTable {
    JobSpec job;
    Table table;
};

/// Fine tables over every parameter that do not know the scene: what the reduced ones are held
/// against. The split sum and the average are quadrature's.
struct FullSet {
    std::vector<JobSpec> jobs;       ///< those that the plan's lobes need
    std::vector<TableKind> kinds;    ///< of each
    std::vector<BakedTable> tables;  ///< baked, in the same order
};
FullSet full_set_of(const ScenePlan& plan);

/// How far one lobe's albedo from the plan's tables is from that of the full set.
struct LobeProof {
    std::size_t material = 0;  ///< position in SceneUse::materials
    Lobe lobe = Lobe::metal;
    double max = 0, rms = 0;
    double NoV = 0, roughness = 0;  ///< of max
};

/// Directions, roughnesses and colours drawn at random for each lobe.
inline constexpr int kProofPoints = 1024;

/// For every lobe of every material that reads a table or a closed form. `tables` are the plan's,
/// in its order.
std::vector<LobeProof> prove(const ScenePlan& plan, const std::vector<BakedTable>& tables,
                             const FullSet& full);

}  // namespace kiln::client
