// SPDX-License-Identifier: Apache-2.0
// `kiln plan` and `kiln bake --scene`.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>

#include "client/bakery.h"
#include "client/commands.h"
#include "client/files.h"
#include "client/interrupt.h"
#include "client/scene.h"
#include "server/base/sha256.h"
#include "server/image/image.h"
#include "server/scene/plan_options.h"
#include "server/spec/limits.h"
#include "server/spec/words.h"

namespace kiln::client {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kManifestBytesMost = 64u << 20;
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

/// A folder of tables as an earlier bake left it.
class Folder {
  public:
    explicit Folder(std::string path) : path_(std::move(path)) {
        std::error_code failed;
        fs::create_directories(path_, failed);
        if (!fs::is_directory(path_, failed))
            throw Failure(Exit::usage, "cannot_write", "-o " + path_ + " is no folder");
        check_output(path_ + "/manifest.json");
        if (fs::is_regular_file(path_ + "/manifest.json", failed))
            files_ = read_manifest(read_input(path_ + "/manifest.json", kManifestBytesMost));
    }

    /// The bytes of a table that is there, whole, and made by `engine`.
    std::optional<std::string> find(const std::string& id, const std::string& engine) const {
        for (const SceneFile& file : files_) {
            std::error_code failed;
            if (file.id != id || file.engine != engine || engine.empty() ||
                !fs::is_regular_file(path_ + "/" + file.file, failed))
                continue;
            std::string bytes = read_input(path_ + "/" + file.file, std::size_t{1} << 30);
            if (sha256_hex(bytes) == file.sha256) return bytes;
        }
        return std::nullopt;
    }

    void write(const std::string& file, const std::string& bytes) const {
        write_output(path_ + "/" + file, bytes);
    }

    /// What the manifest before named and this one does not.
    void clear(const std::vector<SceneTable>& now) const {
        for (const SceneFile& file : files_) {
            const bool named = std::any_of(now.begin(), now.end(), [&](const SceneTable& table) {
                return table.file.file == file.file;
            });
            std::error_code ignored;
            if (!named) fs::remove(path_ + "/" + file.file, ignored);
        }
    }

  private:
    std::string path_;
    std::vector<SceneFile> files_;
};

class SceneBake {
  public:
    SceneBake(const SceneOptions& options, const Folder& folder, Bakery& bakery)
        : options_(options), folder_(folder), bakery_(bakery), engine_(bakery.engine()) {}

    /// Every table of the plan: kept, or baked together with what the proof still lacks.
    void bake(const ScenePlan& plan) {
        tables_.assign(plan.tables.size(), {});
        images_.assign(plan.tables.size(), "");
        std::vector<JobSpec> jobs;
        std::vector<std::size_t> places;
        for (std::size_t i = 0; i < plan.tables.size(); ++i) {
            const PlannedTable& table = plan.tables[i];
            tables_[i].file = {table.name, file_of(table), table.id, "", engine_};
            if (auto bytes = folder_.find(table.id, engine_)) {
                take(i, std::move(*bytes));
                tables_[i].kept = true;
                continue;
            }
            jobs.push_back(table.job);
            places.push_back(i);
        }
        const bool first = options_.prove && full_.tables.empty();
        if (first) full_ = full_set_of(plan);
        if (first) jobs.insert(jobs.end(), full_.jobs.begin(), full_.jobs.end());
        if (jobs.empty()) return;
        std::vector<Baking> baked = bakery_.bake(jobs, {});
        for (std::size_t k = 0; k < places.size(); ++k) {
            tables_[places[k]].cached = baked[k].cached;
            tables_[places[k]].report = std::move(baked[k].report);
            take(places[k], std::move(baked[k].image));
        }
        for (std::size_t k = places.size(); k < baked.size(); ++k) {
            full_.tables.push_back(decoded(jobs[k], baked[k].image));
            fine_cached_ += baked[k].cached ? 1 : 0;
        }
    }

    std::vector<LobeProof> proof(const ScenePlan& plan) const {
        if (!options_.prove) return {};
        std::vector<BakedTable> baked;
        for (std::size_t i = 0; i < images_.size(); ++i)
            baked.push_back(decoded(plan.tables[i].job, images_[i]));
        return prove(plan, baked, full_);
    }

    void write(const ScenePlan& plan) const {
        for (std::size_t i = 0; i < images_.size(); ++i)
            folder_.write(tables_[i].file.file, images_[i]);
        folder_.write("manifest.json", manifest_json(plan, tables_) + "\n");
        folder_.clear(tables_);
    }

    void tell(SceneReport& report) const {
        report.tables = tables_;
        report.fine_tables = full_.tables.size();
        report.fine_tables_cached = fine_cached_;
    }

  private:
    void take(std::size_t index, std::string bytes) {
        tables_[index].byte_count = bytes.size();
        tables_[index].file.sha256 = sha256_hex(bytes);
        images_[index] = std::move(bytes);
    }

    const SceneOptions& options_;
    const Folder& folder_;
    Bakery& bakery_;
    std::string engine_;
    std::vector<SceneTable> tables_;
    std::vector<std::string> images_;
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
    const Folder folder(options.output);
    const Interrupt interrupt(options.timeout_s);
    const Stop stop(interrupt, options.timeout_s);
    // Tables of a scene take milliseconds: OpenCL where its program is at hand.
    const auto bakery = open_bakery(options, stop, std::chrono::milliseconds(0));
    SceneBake bake(options, folder, *bakery);
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
    bake.tell(report);
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
