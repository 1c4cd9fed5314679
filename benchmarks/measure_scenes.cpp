// SPDX-License-Identifier: Apache-2.0
// measure_scenes SCENE...: what each scene's plan costs beside the full set that does not look at
// the scene, with the same options, as rows of Markdown: bytes of the files, BRDF evaluations that
// the engine counted, seconds of integration and encoding (the least of some runs that take turns),
// and the largest difference of any lobe's albedo from fine tables at the same random points. Where
// the plan's is the larger one, nodes are added until it is not: the evaluations at equal error.
// Native backend.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "client/proof.h"
#include "server/base/error.h"
#include "server/image/image.h"
#include "server/scene/plan_options.h"
#include "server/worker/bake.h"

namespace {

using namespace kiln;
using namespace kiln::client;

constexpr int kRuns = 5;

struct Cost {
    std::size_t tables = 0, bytes = 0;
    std::uint64_t evaluations = 0;
    double seconds = 0, error = 0;
};

struct Bakes {
    std::vector<BakedTable> tables;
    Cost cost;
};

Bakes bake_all(Engine& engine, const std::vector<JobSpec>& jobs) {
    Bakes bakes;
    for (const JobSpec& job : jobs) {
        const Baked baked = kiln::bake(engine, job, Control{});
        bakes.cost.seconds += baked.report.run_time_s.integrate + baked.report.run_time_s.encode;
        bakes.cost.bytes += baked.image.size();
        bakes.cost.evaluations += baked.report.work.brdf_evaluations;
        bakes.tables.push_back({job, decode(baked.image).table});
        ++bakes.cost.tables;
    }
    return bakes;
}

std::vector<JobSpec> jobs_of(const std::vector<PlannedTable>& tables) {
    std::vector<JobSpec> jobs;
    for (const PlannedTable& table : tables) jobs.push_back(table.job);
    return jobs;
}

/// The same lobes, each reading the full set of the plan's own options.
ScenePlan reading_full(const ScenePlan& plan) {
    ScenePlan result = plan;
    result.tables = plan.full;
    const auto position = [&](const std::string& name) -> std::optional<std::size_t> {
        for (std::size_t i = 0; i < plan.full.size(); ++i)
            if (plan.full[i].name == name) return i;
        return std::nullopt;
    };
    for (MaterialPlan& material : result.materials)
        for (LobePlan& lobe : material.lobes) {
            if (lobe.need.lobe == Lobe::sheen) {
                lobe.table = position("sheen");
            } else if (lobe.need.lobe == Lobe::diffuse) {
                lobe.table = position("diffuse");
            } else if (lobe.reading == Reading::all_reflected) {
                lobe.table = plan.full.size();  // E = A + B, which stands behind the others
            } else {
                lobe.reading = Reading::two_channels;
                lobe.added = plan.options.multiscatter;
                lobe.table = position("specular");
                lobe.average = position("average");
            }
        }
    return result;
}

/// E of a split sum.
BakedTable sum_of_channels(BakedTable split) {
    for (std::size_t i = 0; i < split.table.planes[0].size(); ++i)
        split.table.planes[0][i] += split.table.planes[1][i];
    return split;
}

double worst(const std::vector<LobeProof>& proofs) {
    double most = 0;
    for (const LobeProof& proof : proofs) most = std::max(most, proof.max);
    return most;
}

std::string read(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

double median(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    const std::size_t n = values.size();
    return n == 0 ? 0 : (values[(n - 1) / 2] + values[n / 2]) / 2;
}

struct Ratios {
    std::vector<double> bytes, evaluations, equal, seconds;
};

double ratio(std::uint64_t a, std::uint64_t b) {
    return static_cast<double>(a) / static_cast<double>(b);
}

/// Evaluations of the plan with the fewest nodes from those of `options` on whose largest error is
/// at most this one; `nodes` is theirs.
std::uint64_t evaluations_at(Engine& engine, const SceneUse& scene, PlanOptions options,
                             const FullSet& fine, double error_max, std::int64_t& nodes) {
    for (;; ++options.resolution) {
        const ScenePlan plan = plan_scene(scene, options);
        const Bakes bakes = bake_all(engine, jobs_of(plan.tables));
        nodes = options.resolution;
        if (worst(prove(plan, bakes.tables, fine)) <= error_max) return bakes.cost.evaluations;
        if (nodes > 256) throw Error("no_equal_error", "no equal error below 256 nodes");
    }
}

void measure(Engine& engine, const std::string& path, const PlanOptions& options, Ratios& ratios) {
    const SceneUse scene = read_scene(read(path), {});
    const ScenePlan plan = plan_scene(scene, options);
    FullSet fine = full_set_of(plan);
    fine.tables = bake_all(engine, fine.jobs).tables;
    Bakes reduced, full;
    double reduced_s = 1e9, full_s = 1e9;
    for (int run = 0; run < kRuns; ++run) {
        reduced = bake_all(engine, jobs_of(plan.tables));
        full = bake_all(engine, jobs_of(plan.full));
        reduced_s = std::min(reduced_s, reduced.cost.seconds);
        full_s = std::min(full_s, full.cost.seconds);
    }
    full.tables.push_back(sum_of_channels(full.tables.front()));
    reduced.cost.error = worst(prove(plan, reduced.tables, fine));
    full.cost.error = worst(prove(reading_full(plan), full.tables, fine));
    const Cost &a = reduced.cost, &b = full.cost;
    std::int64_t nodes = 0;
    const std::uint64_t equal = evaluations_at(engine, scene, options, fine, b.error, nodes);
    std::printf(
        "| %s | %zu / %zu | %zu / %zu | %.3g / %.3g M | %.2e / %.2e | %.3g M (%lld) | %.1f / %.0f "
        "|\n",
        std::filesystem::path(path).stem().c_str(), a.tables, b.tables, a.bytes, b.bytes,
        static_cast<double>(a.evaluations) / 1e6, static_cast<double>(b.evaluations) / 1e6, a.error,
        b.error, static_cast<double>(equal) / 1e6, static_cast<long long>(nodes), 1e3 * reduced_s,
        1e3 * full_s);
    std::fflush(stdout);
    ratios.bytes.push_back(ratio(a.bytes, b.bytes));
    ratios.evaluations.push_back(ratio(a.evaluations, b.evaluations));
    ratios.equal.push_back(ratio(equal, b.evaluations));
    ratios.seconds.push_back(reduced_s / full_s);
}

}  // namespace

int main(int argc, char** argv) {
    EngineOptions native;
    native.device = DeviceChoice::native;
    Engine engine(native);
    std::vector<std::string> scenes(argv + 1, argv + argc);
    std::sort(scenes.begin(), scenes.end());
    try {
        for (const char* diffuse : {"lambert", "burley"}) {
            Ratios ratios;
            std::printf(
                "\nDiffuse model %s:\n\n| scene | tables | bytes | evaluations | largest error | "
                "evaluations at equal error (nodes) | ms |\n|---|---|---|---|---|---|---|\n",
                diffuse);
            const PlanOptions options =
                read_plan_request({{"diffuse", diffuse}, {"device", "native"}}).options;
            for (const std::string& scene : scenes) measure(engine, scene, options, ratios);
            std::printf("| median of the ratios | | %.2f | %.2f | | %.2f | %.2f |\n",
                        median(ratios.bytes), median(ratios.evaluations), median(ratios.equal),
                        median(ratios.seconds));
        }
    } catch (const Error& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 1;
    }
    return 0;
}
