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
    std::string engine;  ///< that made it
};

/// What one bake of a scene did with one table.
struct SceneTable {
    SceneFile file;
    std::size_t byte_count = 0;
    bool kept = false;    ///< the folder had it
    bool cached = false;  ///< the server had it
    std::string report;   ///< JSON, "" where kept
};

struct SceneReport {
    std::string scene;  ///< as named on the command line
    std::string where;  ///< the server, "" for this process
    std::vector<SceneTable> tables;
    std::vector<LobeProof> proof;
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

/// The files that a manifest lists; empty for what is no manifest of ours. File names are plain
/// ones: no path.
std::vector<SceneFile> read_manifest(std::string_view text);

}  // namespace kiln::client
