// SPDX-License-Identifier: Apache-2.0
// The two documents beside the tables of a scene: the manifest for engines, the report for people.
#include <algorithm>
#include <nlohmann/json.hpp>

#include "client/json.h"
#include "client/scene.h"
#include "server/base/sha256.h"

namespace kiln::client {

namespace {

using Json = nlohmann::ordered_json;

constexpr int kManifestVersion = 1;

/// Of a bake's own making: a lower-case word and an extension, nothing that leaves the folder.
bool is_plain_name(const std::string& name) {
    const std::size_t dot = name.find('.');
    if (dot == std::string::npos || dot == 0 || name.size() > 64) return false;
    const std::string extension = name.substr(dot + 1);
    return (extension == "exr" || extension == "png") &&
           std::all_of(name.begin(), name.begin() + static_cast<std::ptrdiff_t>(dot), [](char c) {
               return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_';
           });
}

std::string text_at(const Json& object, const char* key) {
    const auto found = object.find(key);
    return found != object.end() && found->is_string() ? found->get<std::string>() : "";
}

Json proof_json(const LobeProof& proof) {
    return {{"material", proof.material}, {"lobe", to_word(proof.lobe)},
            {"max", proof.max},           {"rms", proof.rms},
            {"NoV", proof.NoV},           {"roughness", proof.roughness}};
}

}  // namespace

std::string manifest_json(const ScenePlan& plan, const std::vector<SceneTable>& tables) {
    const Json document = Json::parse(to_json(plan));
    Json list = Json::array();
    for (std::size_t i = 0; i < tables.size(); ++i) {
        const Json& planned = document["tables"][i];
        const SceneFile& file = tables[i].file;
        list.push_back({{"name", file.name},
                        {"file", file.file},
                        {"id", file.id},
                        {"sha256", file.sha256},
                        {"engine", file.engine},
                        {"kind", planned["job"]["kind"]},
                        {"pixel", planned["job"]["output"]["pixel"]},
                        {"resolution", planned["job"]["resolution"]}});
        if (!file.sidecar.empty())
            list.back()["sidecar"] = {{"file", file.sidecar}, {"sha256", file.sidecar_sha256}};
        else
            list.back().update(
                {{"quantities", planned["job"]["quantities"]}, {"lookup", planned["lookup"]}});
        list.back()["serves"] = planned["serves"];
    }
    return Json{{"kiln_manifest", kManifestVersion},  {"tables", list},
                {"materials", document["materials"]}, {"options", document["options"]},
                {"unserved", document["unserved"]},   {"warnings", document["warnings"]}}
        .dump(2);
}

std::string sidecar_of(const std::string& file) {
    return file.substr(0, file.find('.')) + ".sidecar.json";
}

std::vector<MeasuredProof> measured_proofs(const ScenePlan& plan,
                                           const std::vector<SceneTable>& tables) {
    std::vector<MeasuredProof> proofs;
    for (const MaterialPlan& material : plan.materials) {
        if (!material.measured) continue;
        MeasuredProof worst{.material = material.material};
        for (const SliceError& slice : read_lookup_errors(
                 tables[material.measured->table].bytes.sidecar, material.measured->cell))
            if (slice.lookup_error > worst.lookup_error)
                worst = {material.material, slice.lookup_error, slice.theta_in};
        proofs.push_back(worst);
    }
    return proofs;
}

std::vector<SceneFile> read_manifest(std::string_view text) {
    const Json json = Json::parse(text.begin(), text.end(), nullptr, false);
    std::vector<SceneFile> files;
    if (!json.is_object() || json.value("kiln_manifest", Json()) != Json(kManifestVersion))
        return files;
    const auto tables = json.find("tables");
    if (tables == json.end() || !tables->is_array()) return files;
    for (const Json& entry : *tables) {
        if (!entry.is_object()) continue;
        SceneFile file{text_at(entry, "name"),
                       text_at(entry, "file"),
                       text_at(entry, "id"),
                       text_at(entry, "sha256"),
                       text_at(entry, "engine"),
                       "",
                       ""};
        if (!is_plain_name(file.file) || !is_sha256_hex(file.id) || !is_sha256_hex(file.sha256))
            continue;
        const auto sidecar = entry.find("sidecar");
        if (sidecar != entry.end() && sidecar->is_object()) {
            file.sidecar = sidecar_of(file.file);
            file.sidecar_sha256 = text_at(*sidecar, "sha256");
        }
        files.push_back(std::move(file));
    }
    return files;
}

std::string scene_report_json(const ScenePlan& plan, const SceneReport& report) {
    const Json document = Json::parse(to_json(plan));
    Json tables = Json::array(), proof = Json::array(), measured = Json::array();
    std::uint64_t evaluations = 0, fresnel = 0, multiscatter = 0, bytes = 0;
    for (const SceneTable& table : report.tables) {
        const auto made = read_report(table.report);
        const Work work = made ? made->work : Work{};
        evaluations += work.brdf_evaluations;
        fresnel += work.fresnel_evaluations;
        multiscatter += work.multiscatter_evaluations;
        bytes += table.bytes.image.size();
        tables.push_back(
            {{"name", table.file.name},
             {"file", table.file.file},
             {"id", table.file.id},
             {"bytes", table.bytes.image.size()},
             {"kept", table.kept},
             {"cached", table.cached},
             {"report", table.report.empty() ? Json(nullptr) : Json::parse(table.report)}});
    }
    for (const LobeProof& lobe : report.proof) proof.push_back(proof_json(lobe));
    for (const MeasuredProof& entry : report.measured)
        measured.push_back({{"material", entry.material},
                            {"lookup_error", entry.lookup_error},
                            {"theta_in_deg", entry.theta_in}});
    return Json{{"scene", report.scene},
                {"server", report.where.empty() ? Json(nullptr) : Json(report.where)},
                {"seconds", report.seconds},
                {"tables", tables},
                {"bytes", bytes},
                {"work",
                 {{"brdf_evaluations", evaluations},
                  {"fresnel_evaluations", fresnel},
                  {"multiscatter_evaluations", multiscatter}}},
                {"full", document["full"]["estimate"]},
                {"proof",
                 {{"points", kProofPoints},
                  {"fine_tables", report.fine_tables},
                  {"fine_tables_cached", report.fine_tables_cached},
                  {"max_error", report.max_error ? Json(*report.max_error) : Json(nullptr)},
                  {"max", report.error_max()},
                  {"holds", report.holds()},
                  {"rounds", report.rounds},
                  {"lobes", proof},
                  {"measured", measured}}},
                {"left_out", document["left_out"]},
                {"unserved", document["unserved"]},
                {"warnings", document["warnings"]}}
        .dump(2, ' ', false, Json::error_handler_t::replace);
}

}  // namespace kiln::client
