// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <map>

#include "client/json.h"
#include "client/scene.h"
#include "client/summary.h"
#include "client/terminal.h"
#include "server/spec/channels.h"
#include "server/spec/kinds.h"

namespace kiln::client {

namespace {

std::string counted(std::size_t count, const std::string& noun) {
    return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

/// 65536 → 65.5 k
std::string in_thousands(double count) {
    const char* units[] = {"", " k", " M", " G"};
    std::size_t unit = 0;
    while (count >= 1000 && unit < 3) count /= 1000, ++unit;
    char text[32];
    std::snprintf(text, sizeof text, "%.3g", count);
    return text + std::string(units[unit]);
}

std::string channels_in_words(const JobSpec& job) {
    if (is_measured(job.kind))
        return std::to_string(job.measured.materials.size()) + " x " +
               std::to_string(job.measured.theta_in.size()) + " slices of R, G, B";
    std::string text;
    for (const Channel& channel : channels_of(job))
        text += (text.empty() ? "" : ", ") + channel.name;
    return text;
}

std::string roughness_of(const JobSpec& job) {
    if (is_measured(job.kind)) return "measured";
    const Axis& axis = job.axes.back();
    const std::int64_t rows = job.resolution.back();
    if (rows == 1) return format_number(axis.flip ? axis.hi : axis.lo);
    return format_number(axis.lo) + " to " + format_number(axis.hi);
}

std::string name_of(const MaterialUse& material) {
    if (!material.name.empty() || !material.index) return printable(material.name);
    return "material " + std::to_string(*material.index);
}

Estimate sum_of(const std::vector<PlannedTable>& tables) {
    Estimate sum;
    for (const PlannedTable& table : tables) sum.add(table.estimate);
    return sum;
}

void add_headline(std::vector<std::string>& lines, const ScenePlan& plan, const std::string& name) {
    const SceneUse& scene = plan.scene;
    std::string head = printable(name) + "  " + scene.format;
    if (scene.scene)
        head +=
            ", scene " + std::to_string(*scene.scene) + " of " + std::to_string(scene.scene_count);
    head += ": " + counted(scene.materials.size(), "material");
    if (!scene.unused.empty()) head += ", " + std::to_string(scene.unused.size()) + " more unused";
    lines.push_back(head);
    LobeSet lobes;
    for (const MaterialUse& material : scene.materials) lobes.add(material.lobes);
    std::string words;
    for (std::size_t i = 0; i < kLobeCount; ++i)
        if (lobes.has(static_cast<Lobe>(i)))
            words += (words.empty() ? "" : ", ") + std::string(to_word(static_cast<Lobe>(i)));
    if (!plan.measured.empty()) words += std::string(words.empty() ? "" : ", ") + "measured";
    lines.push_back("  " + (words.empty() ? "no lobe that is lit" : words));
}

void add_entries(std::vector<std::string>& lines, const char* title,
                 const std::vector<LeftOutOfPlan>& entries) {
    if (entries.empty()) return;
    lines.push_back("");
    lines.push_back(title);
    for (const LeftOutOfPlan& entry : entries) {
        lines.push_back("  " + printable(entry.what));
        lines.push_back("      " + printable(entry.why));
    }
}

void add_total(std::vector<std::string>& lines, const ScenePlan& plan) {
    const Estimate sum = sum_of(plan.tables), full = sum_of(plan.full);
    lines.push_back("");
    const std::string all = in_thousands(static_cast<double>(full.evaluations)) +
                            " evaluations and " + format_bytes(full.bytes);
    if (plan.tables.empty())
        lines.push_back("nothing to bake; without looking at the scene: " + all);
    else
        lines.push_back(in_thousands(static_cast<double>(sum.evaluations)) + " evaluations and " +
                        format_bytes(sum.bytes) +
                        " of texels; without looking at the scene: " + all);
}

/// By why they are not used; the names of a few.
void add_unused(std::vector<std::string>& lines, const ScenePlan& plan) {
    constexpr std::size_t kNamesMost = 8;
    std::map<std::string, std::vector<std::string>> names;
    for (const UnusedMaterial& material : plan.scene.unused)
        names[material.why].push_back(material.name.empty()
                                          ? "material " + std::to_string(material.index)
                                          : printable(material.name));
    if (names.empty()) return;
    lines.push_back("");
    lines.push_back("not used");
    for (const auto& [why, list] : names) {
        std::string text;
        for (std::size_t i = 0; i < std::min(list.size(), kNamesMost); ++i)
            text += (i == 0 ? "" : ", ") + list[i];
        if (list.size() > kNamesMost)
            text += " and " + std::to_string(list.size() - kNamesMost) + " more";
        lines.push_back("  " + text);
        lines.push_back("      " + printable(why));
    }
}

void add_notes(std::vector<std::string>& lines, const ScenePlan& plan) {
    std::size_t shown = 0;
    const auto add = [&](const std::string& line) {
        if (shown++ == 0) lines.push_back("");
        lines.push_back(line);
    };
    for (const std::string& warning : plan.scene.warnings) add("warning: " + printable(warning));
    for (const MaterialUse& material : plan.scene.materials)
        for (const std::string& note : material.notes)
            add("note: " +
                printable((material.index ? "material " + std::to_string(*material.index) + ", "
                                          : std::string()) +
                          note));
}

void add_measured(std::vector<std::string>& lines, const ScenePlan& plan,
                  const SceneReport& report) {
    if (report.measured.empty()) return;
    const auto worst = std::max_element(report.measured.begin(), report.measured.end(),
                                        [](const MeasuredProof& a, const MeasuredProof& b) {
                                            return a.lookup_error < b.lookup_error;
                                        });
    lines.push_back(
        "  " + counted(report.measured.size(), "measured material") +
        ": lookup between texels moves at most " + format_error(worst->lookup_error) +
        " of a slice's light; worst: " + name_of(plan.scene.materials[worst->material]) +
        " at theta_in " + format_number(worst->theta_in) +
        (report.max_error ? "; --max-error does not bound that" : ""));
}

}  // namespace

double SceneReport::error_max() const {
    double max = 0;
    for (const LobeProof& lobe : proof) max = std::max(max, lobe.max);
    return max;
}

std::vector<std::string> plan_lines(const ScenePlan& plan, const std::string& name) {
    std::vector<std::string> lines;
    add_headline(lines, plan, name);
    if (!plan.tables.empty()) {
        lines.push_back("");
        std::vector<std::vector<std::string>> rows{
            {"table", "size", "roughness", "evaluations", "texels", "serves", "channels"}};
        for (const PlannedTable& table : plan.tables)
            rows.push_back({table.name, image_size(table.job), roughness_of(table.job),
                            in_thousands(static_cast<double>(table.estimate.evaluations)),
                            format_bytes(table.estimate.bytes), std::to_string(table.serves.size()),
                            channels_in_words(table.job)});
        for (const std::string& line : columns(rows)) lines.push_back(line);
    }
    add_total(lines, plan);
    add_entries(lines, "left out", plan.left_out);
    add_entries(lines, "not served by any table", plan.unserved);
    add_unused(lines, plan);
    add_notes(lines, plan);
    return lines;
}

std::vector<std::string> report_lines(const ScenePlan& plan, const SceneReport& report,
                                      const std::string& folder) {
    std::vector<std::string> lines;
    std::vector<std::vector<std::string>> rows;
    std::size_t baked = 0;
    for (const SceneTable& table : report.tables) {
        const auto made = read_report(table.report);
        baked += table.kept ? 0 : 1;
        rows.push_back({"  " + table.file.file, format_bytes(table.bytes.image.size()),
                        table.kept     ? "kept"
                        : table.cached ? "cached"
                        : made         ? format_seconds(made->run_time_s.total)
                                       : ""});
    }
    lines.push_back(printable(folder) + "  " + counted(report.tables.size(), "table") + ", " +
                    std::to_string(baked) + " baked" +
                    (report.where.empty() ? "" : " on " + printable(report.where)) + ", " +
                    format_seconds(report.seconds));
    for (const std::string& line : columns(rows)) lines.push_back(line);
    if (!report.proof.empty()) {
        const auto worst =
            std::max_element(report.proof.begin(), report.proof.end(),
                             [](const LobeProof& a, const LobeProof& b) { return a.max < b.max; });
        lines.push_back("  albedo within " + format_error(worst->max) + " of the full set at " +
                        std::to_string(kProofPoints) +
                        " random angles a lobe; worst: " + std::string(to_word(worst->lobe)) +
                        " of " + name_of(plan.scene.materials[worst->material]) + " at NoV " +
                        format_number(worst->NoV) + ", roughness " +
                        format_number(worst->roughness));
    }
    add_measured(lines, plan, report);
    if (report.rounds > 1)
        lines.push_back("  refined " +
                        counted(static_cast<std::size_t>(report.rounds - 1), "time") + " to " +
                        std::to_string(plan.options.resolution) + " nodes and " +
                        std::to_string(plan.options.sample_count) + " samples" +
                        (report.holds() ? ", which holds the bound" : ""));
    for (const LeftOutOfPlan& entry : plan.unserved)
        lines.push_back("  not served: " + printable(entry.what) + " (" + printable(entry.why) +
                        ")");
    for (const std::string& warning : plan.scene.warnings)
        lines.push_back("  warning: " + printable(warning));
    return lines;
}

}  // namespace kiln::client
