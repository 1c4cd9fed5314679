// SPDX-License-Identifier: Apache-2.0
#include <nlohmann/json.hpp>

#include "server/scene/atlas_jobs.h"
#include "server/scene/scene_plan.h"
#include "server/spec/axis_value.h"
#include "server/spec/kinds.h"
#include "server/spec/spec.h"
#include "server/spec/words.h"

namespace kiln {

namespace {

using Json = nlohmann::ordered_json;

Json json_of(const Range& range) {
    return {{"range", {range.lo, range.hi}}, {"origin", to_word(range.origin)}};
}

Json json_of(const ColourRange& colour) {
    Json lo = Json::array(), hi = Json::array();
    Origin origin = Origin::factor;
    for (const Range& channel : colour) {
        lo.push_back(channel.lo);
        hi.push_back(channel.hi);
        origin = std::max(origin, channel.origin);
    }
    return {{"lo", lo}, {"hi", hi}, {"origin", to_word(origin)}};
}

Json json_of(const LobeSet& lobes) {
    Json words = Json::array();
    for (std::size_t i = 0; i < kLobeCount; ++i)
        if (lobes.has(static_cast<Lobe>(i))) words.push_back(to_word(static_cast<Lobe>(i)));
    return words;
}

Json json_of(const Estimate& estimate) {
    return {{"evaluations", estimate.evaluations},
            {"bytes", estimate.bytes},
            {"seconds", estimate.seconds}};
}

/// Texture coordinate = scale · m(parameter) + offset, with m the mapping; texels on nodes.
Json lookup_of(const Axis& axis, std::int64_t count) {
    const double n = static_cast<double>(count);
    const double step = mapped(axis, axis.hi) - mapped(axis, axis.lo);
    const double scale = count == 1 ? 0 : (n - 1) / n / step;
    const double offset = count == 1 ? 0.5 : 0.5 / n - scale * mapped(axis, axis.lo);
    return {{"parameter", to_word(axis.parameter)},
            {"mapping", to_word(axis.mapping)},
            {"scale", scale},
            {"offset", offset}};
}

Json json_of(const AngleLookup& along, const char* angle) {
    return {{"parameter", angle},
            {"mapping", to_word(Mapping::linear)},
            {"scale", along.scale},
            {"offset", along.offset}};
}

/// Where a material that is measured finds each slice of itself.
Json json_of(const MeasuredPlace& place, const std::string& id, const ScenePlan& plan) {
    const PlannedTable& atlas = plan.tables[place.table];
    Json slices = Json::array();
    for (const SliceLookup& slice : slice_lookups(atlas.job, place.cell))
        slices.push_back({{"theta_in_deg", slice.theta_in},
                          {"x", json_of(slice.phi_d, "phi_d")},
                          {"y", json_of(slice.theta_d, "theta_d")}});
    return {{"data", id}, {"table", atlas.name}, {"cell", place.cell}, {"slices", slices}};
}

Json json_of(const PlannedTable& table) {
    Json serves = Json::array();
    for (const Served& served : table.serves) {
        serves.push_back({{"material", served.material}});
        if (served.lobe) serves.back()["lobe"] = to_word(*served.lobe);
    }
    Json json = {{"name", table.name},
                 {"id", table.id},
                 {"job", Json::parse(canonical(table.job))},
                 {"serves", serves}};
    if (!is_measured(table.job.kind)) {
        json["lookup"] = {{"x", lookup_of(table.job.axes[0], table.job.resolution[0])}};
        if (table.job.axes.size() > 1)
            json["lookup"]["y"] = lookup_of(table.job.axes[1], table.job.resolution[1]);
    }
    json["estimate"] = json_of(table.estimate);
    return json;
}

Json json_of(const LobePlan& lobe, const ScenePlan& plan) {
    const auto name = [&](const std::optional<std::size_t>& table) {
        return table ? Json(plan.tables[*table].name) : Json(nullptr);
    };
    return {{"lobe", to_word(lobe.need.lobe)},
            {"roughness", {lobe.need.roughness.lo, lobe.need.roughness.hi}},
            {"table", name(lobe.table)},
            {"average", name(lobe.average)},
            {"albedo", albedo_in_symbols(lobe)}};
}

Json json_of(const MaterialUse& use, const MaterialPlan& material, const ScenePlan& plan) {
    Json reads = Json::array();
    for (const LobePlan& lobe : material.lobes) reads.push_back(json_of(lobe, plan));
    const LobeSet& lobes = use.lobes;
    Json json = {{"index", use.index ? Json(*use.index) : Json(nullptr)},
                 {"name", use.name},
                 {"unlit", use.unlit},
                 {"lobes", json_of(lobes)}};
    if (lobes.has(Lobe::specular_glossiness)) {
        json["roughness"] = json_of(use.roughness);
        json["f0"] = json_of(use.f0);
    } else if (lobes.has(Lobe::metal) || lobes.has(Lobe::dielectric) || lobes.has(Lobe::diffuse)) {
        json["roughness"] = json_of(use.roughness);
        json["metallic"] = json_of(use.metallic);
    }
    if (lobes.has(Lobe::metal)) json["metal_f0"] = json_of(use.metal_f0);
    if (lobes.has(Lobe::dielectric)) {
        json["ior"] = use.ior;
        json["f0"] = json_of(use.f0);
        json["f90"] = json_of(use.f90);
    }
    if (lobes.has(Lobe::sheen)) json["sheen_roughness"] = json_of(use.sheen_roughness);
    if (lobes.has(Lobe::clearcoat)) json["clearcoat_roughness"] = json_of(use.clearcoat_roughness);
    if (material.measured) json["measured"] = json_of(*material.measured, use.measured, plan);
    json["reads"] = reads;
    json["notes"] = use.notes;
    return json;
}

Json json_of(const PlanOptions& options) {
    return {{"resolution", options.resolution},
            {"sample_count", options.sample_count},
            {"multiscatter", to_word(options.multiscatter)},
            {"diffuse", to_word(options.diffuse)},
            {"device", to_word(options.device)},
            {"format", to_word(options.format)},
            {"pixel", to_word(options.pixel)}};
}

Json json_of(const std::vector<LeftOutOfPlan>& entries) {
    Json list = Json::array();
    for (const LeftOutOfPlan& entry : entries)
        list.push_back({{"what", entry.what}, {"why", entry.why}, {"rule", entry.rule}});
    return list;
}

Json json_of(const std::vector<PlannedTable>& tables) {
    Json list = Json::array();
    for (const PlannedTable& table : tables) list.push_back(json_of(table));
    return list;
}

Estimate sum_of(const std::vector<PlannedTable>& tables) {
    Estimate sum;
    for (const PlannedTable& table : tables) sum.add(table.estimate);
    return sum;
}

}  // namespace

std::string to_json(const ScenePlan& plan) {
    LobeSet lobes;
    Json materials = Json::array(), unused = Json::array();
    for (std::size_t i = 0; i < plan.scene.materials.size(); ++i) {
        lobes.add(plan.scene.materials[i].lobes);
        materials.push_back(json_of(plan.scene.materials[i], plan.materials[i], plan));
    }
    for (const UnusedMaterial& entry : plan.scene.unused)
        unused.push_back({{"index", entry.index}, {"name", entry.name}, {"why", entry.why}});
    const Json document = {
        {"scene",
         {{"format", plan.scene.format},
          {"index", plan.scene.scene ? Json(*plan.scene.scene) : Json(nullptr)},
          {"count", plan.scene.scene_count},
          {"lobes", json_of(lobes)}}},
        {"options", json_of(plan.options)},
        {"tables", json_of(plan.tables)},
        {"estimate", json_of(sum_of(plan.tables))},
        {"left_out", json_of(plan.left_out)},
        {"unserved", json_of(plan.unserved)},
        {"measured", plan.measured},
        {"materials", materials},
        {"unused", unused},
        {"full", {{"tables", json_of(plan.full)}, {"estimate", json_of(sum_of(plan.full))}}},
        {"warnings", plan.scene.warnings}};
    // Names come from a document whose strings were checked to be UTF-8.
    return document.dump();
}

}  // namespace kiln
