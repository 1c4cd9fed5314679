// SPDX-License-Identifier: Apache-2.0
// `kiln plan` and `kiln bake --scene`.
#include <algorithm>
#include <chrono>
#include <cstdio>

#include "client/bakery.h"
#include "client/commands.h"
#include "client/files.h"
#include "client/interrupt.h"
#include "client/scene.h"
#include "client/scene_folder.h"
#include "server/base/sha256.h"
#include "server/image/image.h"
#include "server/scene/plan_options.h"
#include "server/spec/kinds.h"
#include "server/spec/limits.h"
#include "server/spec/words.h"

namespace kiln::client {

namespace {

/// Doublings of resolution, each with four times the samples, before a bound is given up.
constexpr int kRoundsMost = 4;
constexpr std::int64_t kNodesMost = 1024;  // the contract's PlanOptions

PlanRequest request_of(const std::vector<std::string>& settings) {
    std::map<std::string, std::string> options;
    for (const std::string& setting : settings) {
        const std::size_t equals = setting.find('=');
        if (equals == std::string::npos)
            throw Failure(Exit::usage, "bad_setting", "--set " + setting + ": has no '='");
        options[setting.substr(0, equals)] = setting.substr(equals + 1);
    }
    try {
        return read_plan_request(options);
    } catch (const Error& error) {
        throw Failure(Exit::usage, "bad_setting", std::string("--set: ") + error.what());
    }
}

SceneUse read_scene_file(const std::string& path, const SceneChoice& choice) {
    // One byte more than may be: read_scene says what the bound is.
    const auto bytes_max = static_cast<std::size_t>(limits().scene_bytes_max) + 1;
    return read_scene(read_input(path, bytes_max), choice);
}

BakedTable decoded(const JobSpec& job, const std::string& image) {
    return {job, decode(image).table};
}

std::string file_of(const PlannedTable& table) {
    return table.name + "." + std::string(to_word(table.job.format));
}

/// The files that were given; each is one that the scene names.
MeasurementFiles files_of(const std::vector<std::string>& paths, const SceneUse& scene) {
    MeasurementFiles files;
    for (const std::string& path : paths) {
        const std::string id = kMeasurementPrefix + files.add(path);
        const auto names = [&](const auto& material) { return material.measured == id; };
        if (std::none_of(scene.materials.begin(), scene.materials.end(), names) &&
            std::none_of(scene.unused.begin(), scene.unused.end(), names))
            throw Failure(Exit::usage, "unused_measurement",
                          "--measurement " + path + ": the scene names no " + id);
    }
    return files;
}

class SceneBake {
  public:
    SceneBake(const SceneOptions& options, const SceneFolder& folder, const MeasurementFiles& files,
              Bakery& bakery)
        : options_(options),
          folder_(folder),
          files_(files),
          bakery_(bakery),
          makers_(bakery.makers()) {}

    /// Every table of the plan: kept, or baked together with what the proof still lacks.
    void bake(const ScenePlan& plan) {
        const std::vector<SceneTable> before = std::move(tables_);
        tables_.clear();
        std::vector<JobSpec> jobs;
        std::vector<std::size_t> places;
        for (std::size_t i = 0; i < plan.tables.size(); ++i) {
            tables_.push_back(known(plan.tables[i], before));
            if (!tables_[i].bytes.image.empty()) continue;
            jobs.push_back(plan.tables[i].job);
            places.push_back(i);
        }
        const bool first = options_.prove && full_.tables.empty();
        if (first) full_ = full_set_of(plan);
        if (first) jobs.insert(jobs.end(), full_.jobs.begin(), full_.jobs.end());
        if (jobs.empty()) return;
        require_measurements(jobs, plan.scene);
        std::vector<Baking> baked = bakery_.bake(jobs, files_);
        for (std::size_t k = 0; k < places.size(); ++k) {
            SceneTable& table = tables_[places[k]];
            table.cached = baked[k].cached;
            table.report = std::move(baked[k].report);
            take(table, {std::move(baked[k].image), std::move(baked[k].sidecar)});
        }
        for (std::size_t k = places.size(); k < baked.size(); ++k) {
            full_.tables.push_back(decoded(jobs[k], baked[k].image));
            fine_cached_ += baked[k].cached ? 1 : 0;
        }
    }

    std::vector<LobeProof> proof(const ScenePlan& plan) const {
        if (!options_.prove) return {};
        std::vector<BakedTable> baked;
        for (std::size_t i = 0; i < tables_.size(); ++i) {
            const JobSpec& job = plan.tables[i].job;
            // No lobe reads an atlas.
            baked.push_back(is_measured(job.kind) ? BakedTable{job, {}}
                                                  : decoded(job, tables_[i].bytes.image));
        }
        return prove(plan, baked, full_);
    }

    void write(const ScenePlan& plan) const {
        for (const SceneTable& table : tables_) folder_.write(table);
        folder_.write("manifest.json", manifest_json(plan, tables_) + "\n");
        folder_.clear(tables_);
    }

    void tell(const ScenePlan& plan, SceneReport& report) const {
        report.tables = tables_;
        if (options_.prove) report.measured = measured_proofs(plan, tables_);
        report.fine_tables = full_.tables.size();
        report.fine_tables_cached = fine_cached_;
    }

  private:
    /// The table as the folder or an earlier round has it; without bytes where neither does.
    SceneTable known(const PlannedTable& planned, const std::vector<SceneTable>& before) const {
        for (const SceneTable& table : before)
            if (table.file.id == planned.id) return table;
        SceneTable table;
        const bool measured = is_measured(planned.job.kind);
        const std::string file = file_of(planned);
        table.file = {.name = planned.name,
                      .file = file,
                      .id = planned.id,
                      .sha256 = "",
                      .engine = measured ? makers_.measured : makers_.tables,
                      .sidecar = measured ? sidecar_of(file) : "",
                      .sidecar_sha256 = ""};
        if (auto bytes = folder_.find(planned.id, table.file.engine)) {
            take(table, std::move(*bytes));
            table.kept = true;
        }
        return table;
    }

    static void take(SceneTable& table, SceneBytes bytes) {
        table.file.sha256 = sha256_hex(bytes.image);
        if (!table.file.sidecar.empty()) table.file.sidecar_sha256 = sha256_hex(bytes.sidecar);
        table.bytes = std::move(bytes);
    }

    /// Throws Failure(usage) that points to what the jobs need and nobody has.
    void require_measurements(const std::vector<JobSpec>& jobs, const SceneUse& scene) {
        std::vector<Problem> problems;
        for (const JobSpec& job : jobs)
            for (const MeasuredMaterial& cell : job.measured.materials) {
                if (files_.has(cell.data) || bakery_.has_measurement(cell.data)) continue;
                const std::string id = kMeasurementPrefix + cell.data;
                for (const MaterialUse& material : scene.materials)
                    if (material.measured == id)
                        problems.push_back(
                            {measured_pointer(scene, material),
                             "names " + id + ", which is not " +
                                 (bakery_.where().empty() ? "here" : "on " + bakery_.where()) +
                                 "; give its file with --measurement FILE"});
            }
        if (!problems.empty())
            throw Failure(Exit::usage, "measurement_missing",
                          "measured data that the scene uses is missing", std::move(problems));
    }

    const SceneOptions& options_;
    const SceneFolder& folder_;
    const MeasurementFiles& files_;
    Bakery& bakery_;
    Makers makers_;
    std::vector<SceneTable> tables_;
    FullSet full_;
    std::size_t fine_cached_ = 0;
};

/// Twice the nodes and four times the samples, as far as a job may go; false where it may not.
bool refine(PlanOptions& options) {
    const std::int64_t nodes = std::min(2 * options.resolution - 1, kNodesMost);
    const std::int64_t samples = std::min({4 * options.sample_count, limits().sample_count_max,
                                           limits().work_samples_max / (nodes * nodes)});
    const bool finer = nodes > options.resolution || samples > options.sample_count;
    options.resolution = nodes;
    options.sample_count = std::max(samples, options.sample_count);
    return finer && limits().work_samples_max / (nodes * nodes) >= options.sample_count;
}

void print(const std::vector<std::string>& lines) {
    std::string text;
    for (const std::string& line : lines) text += line + "\n";
    write_output("-", text);
}

}  // namespace

Exit plan(const SceneOptions& options) {
    const PlanRequest request = request_of(options.settings);
    const ScenePlan made =
        plan_scene(read_scene_file(options.scene, request.choice), request.options);
    if (options.json)
        write_output("-", to_json(made) + "\n");
    else
        print(plan_lines(made, options.scene));
    return Exit::done;
}

Exit bake_scene(const SceneOptions& options) {
    const auto start = std::chrono::steady_clock::now();
    PlanRequest request = request_of(options.settings);
    const SceneUse scene = read_scene_file(options.scene, request.choice);
    const MeasurementFiles files = files_of(options.measurements, scene);
    const SceneFolder folder(options.output);
    const Interrupt interrupt(options.timeout_s);
    const Stop stop(interrupt, options.timeout_s);
    // Tables of a scene take milliseconds: OpenCL where its program is at hand.
    const auto bakery = open_bakery(options, stop, std::chrono::milliseconds(0));
    SceneBake bake(options, folder, files, *bakery);
    SceneReport report;
    report.scene = options.scene;
    report.where = bakery->where();
    report.max_error = options.max_error;
    ScenePlan made = plan_scene(scene, request.options);
    for (;; ++report.rounds) {
        bake.bake(made);
        report.proof = bake.proof(made);
        if (report.holds() || report.rounds > kRoundsMost || !refine(request.options)) break;
        made = plan_scene(scene, request.options);
    }
    if (interrupt.requested()) stop.leave();
    bake.write(made);
    bake.tell(made, report);
    report.seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    const std::string document = scene_report_json(made, report) + "\n";
    folder.write("report.json", document);
    if (!options.report.empty()) write_output(options.report, document);
    if (options.json) write_output("-", document);
    if (!options.json && options.progress != ProgressMode::json)
        for (const std::string& line : report_lines(made, report, options.output)) say(line);
    if (report.holds()) return Exit::done;
    throw Failure(Exit::different, "max_error",
                  "the albedo is off by up to " + format_error(report.error_max()) +
                      " after all refinement; asked for at most " +
                      format_error(*report.max_error));
}

}  // namespace kiln::client
