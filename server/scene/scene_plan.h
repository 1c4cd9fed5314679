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

/// Before anything is baked. Evaluations are those that the engine will count; seconds those of
/// integration alone at nominal rates; bytes those of uncompressed texels.
struct Estimate {
    std::uint64_t evaluations = 0, bytes = 0;
    double seconds = 0;
    void add(const Estimate& other);
};
Estimate estimate_of(const JobSpec& job);

/// Which lobe of which material (position in SceneUse::materials) reads a table.
struct Served {
    std::size_t material = 0;
    std::optional<Lobe> lobe{};  ///< empty: all of it, measured
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

/// How a lobe's albedo follows from what the plan has for it.
enum class Reading {
    closed_form,    ///< no table: F0 + (F90 − F0) (1 − NoV)^5
    base_colour,    ///< no table: the same at every angle
    two_channels,   ///< F0 A + F90 B, then compensated by the renderer where `added` says so
    one_channel,    ///< the table's only channel
    all_reflected,  ///< 1: F = 1, compensated; the table has E
    times_colour,   ///< the base colour times the table's only channel
};

/// How one lobe gets its albedo.
struct LobePlan {
    rules::Need need;
    Reading reading = Reading::closed_form;
    Multiscatter added = Multiscatter::none;
    std::optional<std::size_t> table, average;  ///< positions in ScenePlan::tables
};

/// The albedo in symbols: A, B, T, E_avg the channels, F0, F90 the material's.
std::string albedo_in_symbols(const LobePlan& lobe);

/// Where measured data stands.
struct MeasuredPlace {
    std::size_t table = 0;  ///< position in ScenePlan::tables
    std::size_t cell = 0;   ///< of the atlas
};

struct MaterialPlan {
    std::size_t material = 0;
    std::vector<LobePlan> lobes{};
    std::optional<MeasuredPlace> measured{};  ///< in place of lobes
};

struct ScenePlan {
    SceneUse scene;
    PlanOptions options;
    std::vector<PlannedTable> tables;
    std::vector<PlannedTable> full;  ///< what would be baked without looking at the scene
    std::vector<LeftOutOfPlan> left_out;
    std::vector<LeftOutOfPlan> unserved;  ///< what the scene has and no table of Kiln is for
    std::vector<MaterialPlan> materials;  ///< one for each of scene.materials
    std::vector<std::string> measured;    ///< ids that the atlas holds
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
