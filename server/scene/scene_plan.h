// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "server/scene/rules.h"
#include "server/scene/scene.h"
#include "server/spec/job_spec.h"

namespace kiln {

/// What the engine that reads the tables does, and how finely they are baked.
struct PlanOptions {
    std::int64_t resolution = 64;  ///< nodes of a full axis
    std::int64_t sample_count = 1024;
    Multiscatter multiscatter = Multiscatter::kulla_conty;
    DiffuseModel diffuse = DiffuseModel::lambert;
    DeviceChoice device = DeviceChoice::automatic;
    ImageFormat format = ImageFormat::exr;
    PixelType pixel = PixelType::half;
};

/// Before anything is baked. Seconds are those of integration alone at nominal rates; bytes those
/// of uncompressed texels.
struct Estimate {
    std::uint64_t evaluations = 0, bytes = 0;
    double seconds = 0;
    void add(const Estimate& other);
};
Estimate estimate_of(const JobSpec& job);

/// Which lobe of which material (position in SceneUse::materials) reads a table.
struct Served {
    std::size_t material = 0;
    Lobe lobe = Lobe::metal;
};

struct PlannedTable {
    std::string name;  ///< "specular", "specular_2", …: unique in the plan, fit for a file's name
    JobSpec job;
    std::string id;
    std::vector<Served> serves;
    Estimate estimate;
};

struct LeftOutOfPlan {
    std::string what, why;
    std::string rule;  ///< the stable word of the rule
};

/// How one lobe gets its albedo.
struct LobePlan {
    Lobe lobe = Lobe::metal;
    Range roughness;
    std::optional<std::size_t> table, average;  ///< positions in ScenePlan::tables
    std::string form;  ///< the albedo in symbols: A, B, T, E the channels, F0, F90 the material's
};

struct MaterialPlan {
    std::size_t material = 0;
    std::vector<LobePlan> lobes;
};

struct ScenePlan {
    SceneUse scene;
    PlanOptions options;
    std::vector<PlannedTable> tables;
    std::vector<PlannedTable> full;  ///< what would be baked without looking at the scene
    std::vector<LeftOutOfPlan> left_out;
    std::vector<LeftOutOfPlan> unserved;  ///< what the scene has and no table of Kiln is for
    std::vector<MaterialPlan> materials;  ///< one for each of scene.materials
    std::vector<std::string> measured;    ///< ids that an atlas has to hold
};

/// The smallest set of tables that renders the scene under image lighting. Throws InvalidScene
/// where the options make no job.
ScenePlan plan_scene(SceneUse scene, const PlanOptions& options);

/// The lowest roughness that a table of Charlie's sheen is baked at: below, D has a spike at the
/// horizon that no table resolves, and readers take the lowest row.
inline constexpr double kSheenRoughnessLeast = 0.07;

/// The contract's Plan as JSON text.
std::string to_json(const ScenePlan& plan);

}  // namespace kiln
