// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "client/proof.h"
#include "server/scene/scene_plan.h"

namespace kiln::client {

/// A baked table of a scene as the folder holds it.
struct SceneFile {
    std::string name, file, id, sha256;
    std::string engine;                   ///< that made it
    std::string sidecar, sidecar_sha256;  ///< file of an atlas, "" of other tables
};

struct SceneBytes {
    std::string image;
    std::string sidecar;  ///< of an atlas
};

/// What one bake of a scene did with one table.
struct SceneTable {
    SceneFile file;
    SceneBytes bytes;
    bool kept = false;    ///< the folder had it
    bool cached = false;  ///< the server had it
    std::string report;   ///< JSON, "" where kept
};

/// Lookup between the texels of an atlas: the most that it moves of a slice's light.
struct MeasuredProof {
    std::size_t material = 0;  ///< position in SceneUse::materials
    double lookup_error = 0;   ///< share of the integral of f cos
    double theta_in = 0;       ///< degrees, of that slice
};

struct SceneReport {
    std::string scene;  ///< as named on the command line
    std::string where;  ///< the server, "" for this process
    std::vector<SceneTable> tables;
    std::vector<LobeProof> proof;
    std::vector<MeasuredProof> measured;                  ///< in the place of a proof
    std::size_t fine_tables = 0, fine_tables_cached = 0;  ///< that the proof was made with
    std::optional<double> max_error;                      ///< the bound that was asked for
    int rounds = 1;                                       ///< of refining until it held
    double seconds = 0;

    double error_max() const;
    bool holds() const { return !max_error || error_max() <= *max_error; }
};

/// For people: what a plan is made of, what it leaves out and why. One line an entry.
std::vector<std::string> plan_lines(const ScenePlan& plan, const std::string& name);
/// The same of what was baked.
std::vector<std::string> report_lines(const ScenePlan& plan, const SceneReport& report,
                                      const std::string& folder);

// JSON texts, without a line break at the end.
std::string manifest_json(const ScenePlan& plan, const std::vector<SceneTable>& tables);
std::string scene_report_json(const ScenePlan& plan, const SceneReport& report);

/// What side-cars say of the materials that are measured.
std::vector<MeasuredProof> measured_proofs(const ScenePlan& plan,
                                           const std::vector<SceneTable>& tables);

/// atlas.exr has atlas.sidecar.json.
std::string sidecar_of(const std::string& file);

/// The files that a manifest lists; empty for what is no manifest of ours. File names are plain
/// ones: no path.
std::vector<SceneFile> read_manifest(std::string_view text);

}  // namespace kiln::client
