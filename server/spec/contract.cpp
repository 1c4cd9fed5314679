// SPDX-License-Identifier: Apache-2.0
#include "server/spec/contract.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <span>

#include "server/spec/batch.h"
#include "server/spec/json_text.h"
#include "server/spec/limits.h"
#include "server/spec/schema.h"
#include "server/spec/words.h"

namespace kiln {

namespace embedded {
extern const std::string_view openapi_json;
}

namespace {

using Json = nlohmann::json;

constexpr const char* kKnownOfDiffuse =
    "/components/schemas/Job/properties/diffuse/properties/model/x-kiln-known";

[[noreturn]] void refuse(const std::string& message) {
    throw Error("contract", "api/openapi.json: " + message);
}

const Json& at(const Json& document, const std::string& pointer) {
    try {
        return document.at(Json::json_pointer(pointer));
    } catch (const Json::exception&) {
        refuse("nothing at " + pointer);
    }
}

template <JobEnum E>
void check_words(const Json& document, const std::string& pointer) {
    Json expected = Json::array();
    for (const std::string_view word : words<E>()) expected.push_back(word);
    if (at(document, "/components/schemas" + pointer + "/enum") != expected)
        refuse(pointer + "/enum differs from the words that the program knows: " + expected.dump());
}

void check_all_words(const Json& document) {
    const std::string job = "/Job/properties/";
    check_words<Kind>(document, job + "kind");
    check_words<Quantity>(document, "/Quantity");
    check_words<Parameter>(document, "/Axis/properties/parameter");
    check_words<Mapping>(document, "/Axis/properties/mapping");
    check_words<Grid>(document, "/Axis/properties/grid");
    check_words<Integrator>(document, job + "integrator");
    check_words<Sampler>(document, job + "sampler");
    check_words<Importance>(document, job + "importance");
    check_words<Distribution>(document, job + "microfacet/properties/distribution");
    check_words<Masking>(document, job + "microfacet/properties/masking");
    check_words<Fresnel>(document, job + "fresnel/properties/model");
    check_words<Metal>(document, job + "fresnel/properties/metal");
    check_words<DiffuseModel>(document, job + "diffuse/properties/model");
    check_words<Coupling>(document, job + "coupling");
    check_words<Multiscatter>(document, job + "multiscatter");
    check_words<Multiscatter>(document, "/PlanOptions/properties/multiscatter");
    check_words<Precision>(document, job + "precision");
    check_words<DeviceChoice>(document, job + "device");
    check_words<ImageFormat>(document, "/Output/properties/format");
    check_words<ImageFormat>(document, "/ImageExtension");
    check_words<PixelType>(document, "/Output/properties/pixel");
    for (const char* owner : {"/Extrapolation", "/MaterialExtrapolation"})
        check_words<ThetaInBeyond>(document, std::string(owner) + "/properties/theta_in");
    for (const auto& [what, models] : at(document, kKnownOfDiffuse).items())
        for (const Json& model : models)
            if (!from_word<DiffuseModel>(model.get<std::string>()))
                refuse(std::string(kKnownOfDiffuse) + "/" + what + ": " + model.dump());
    for (const std::string_view format : words<ImageFormat>()) {
        const std::string pointer =
            "/components/schemas/Output/x-kiln-pixels/" + std::string(format);
        if (at(document, pointer).empty()) refuse(pointer + " is empty");
        for (const Json& pixel : at(document, pointer)) {
            if (!from_word<PixelType>(pixel.get<std::string>()))
                refuse(pointer + ": " + pixel.dump());
        }
    }
}

void check_defaults(const Json& document, const Json& schema, const std::string& place) {
    if (schema.contains("default")) {
        ProblemList problems(1);
        const Json walked = walk_schema(document, schema, schema["default"], problems);
        if (!problems.empty()) refuse(place + "/default " + problems.take()[0].message);
        if (walked != schema["default"]) refuse(place + "/default leaves out " + walked.dump());
    }
    if (!schema.contains("properties")) return;
    for (const auto& [name, property] : schema["properties"].items())
        check_defaults(document, property, place + "/" + name);
}

void check_limits(const Json& document) {
    for (const auto& [name, limit] : at(document, "/x-kiln-limits").items()) {
        if (!limit.contains("same_as")) continue;
        const auto pointer = limit["same_as"].get<std::string>();
        if (at(document, pointer) != limit.at("value"))
            refuse("x-kiln-limits/" + name + " differs from " + pointer);
    }
}

Json load() {
    try {
        Json document = Json::parse(embedded::openapi_json);
        for (const auto& [name, schema] : at(document, "/components/schemas").items()) {
            check_schema(document, schema, "/components/schemas/" + name);
            check_defaults(document, schema, "/components/schemas/" + name);
        }
        for (const auto& [name, parameter] : at(document, "/components/parameters").items())
            check_schema(document, parameter.at("schema"), "/components/parameters/" + name);
        check_all_words(document);
        check_limits(document);
        return document;
    } catch (const Json::exception& error) {
        refuse(error.what());
    }
}

Limits read_limits(const Json& document) {
    const auto value = [&](const char* name) {
        const Json& number = at(document, "/x-kiln-limits/" + std::string(name) + "/value");
        if (!number.is_number_integer())
            refuse("x-kiln-limits/" + std::string(name) + " is no integer");
        return number.get<std::int64_t>();
    };
    return {.job_bytes_max = value("job_bytes_max"),
            .depth_max = value("depth_max"),
            .problems_max = value("problems_max"),
            .resolution_max = value("resolution_max"),
            .sample_count_max = value("sample_count_max"),
            .work_samples_max = value("work_samples_max"),
            .png_channels_max = value("png_channels_max"),
            .wait_s_max = value("wait_s_max"),
            .list_limit_max = value("list_limit_max"),
            .list_limit_default = value("list_limit_default"),
            .batch_jobs_max = value("batch_jobs_max"),
            .batch_bytes_max = value("batch_bytes_max"),
            .scene_bytes_max = value("scene_bytes_max"),
            .scene_entries_max = value("scene_entries_max"),
            .gltf_materials_max = value("gltf_materials_max"),
            .atlas_materials_max = value("atlas_materials_max"),
            .slice_count_max = value("slice_count_max"),
            .gutter_max = value("gutter_max"),
            .atlas_side_max = value("atlas_side_max"),
            .atlas_texels_max = value("atlas_texels_max"),
            .view_side_min = value("view_side_min"),
            .view_side_max = value("view_side_max"),
            .sampling_side_max = value("sampling_side_max")};
}

}  // namespace

std::string_view openapi_text() { return embedded::openapi_json; }

const nlohmann::json& contract() {
    static const Json document = load();
    return document;
}

const Limits& limits() {
    static const Limits values = read_limits(contract());
    return values;
}

void check_contract() { limits(); }

KnownOfModel known_of(DiffuseModel model) {
    const auto listed = [&](const char* what) {
        const Json& models = at(contract(), std::string(kKnownOfDiffuse) + "/" + what);
        return std::find(models.begin(), models.end(), to_word(model)) != models.end();
    };
    return {listed("exceeds_one"), listed("negative"), listed("not_reciprocal")};
}

std::string limits_json() {
    Json entries = at(contract(), "/x-kiln-limits");
    for (Json& entry : entries) entry.erase("same_as");
    return entries.dump();
}

std::vector<Problem> contract_problems(std::string_view component, std::string_view text) {
    const Json& schema = at(contract(), join_pointer("/components/schemas", component));
    // What the program itself says may be larger than a job: the bound of a batch is the widest.
    const Json value = parse_json(text, {limits().batch_bytes_max, limits().depth_max});
    ProblemList problems(static_cast<std::size_t>(limits().problems_max));
    walk_schema(contract(), schema, value, problems);
    return problems.take();
}

std::vector<std::string> batch_jobs(std::string_view text) {
    // Two levels of nesting more than a job: the batch and its list.
    const Json batch = parse_json(text, {limits().batch_bytes_max, limits().depth_max + 2});
    ProblemList problems(static_cast<std::size_t>(limits().problems_max));
    walk_schema(contract(), at(contract(), "/components/schemas/Batch"), batch, problems);
    if (!problems.empty()) throw InvalidJob(problems.take());
    std::vector<std::string> jobs;
    for (const Json& job : batch["jobs"]) jobs.push_back(job.dump());
    return jobs;
}

}  // namespace kiln
