// SPDX-License-Identifier: Apache-2.0
#include "server/http/documents.h"

#include <array>
#include <ctime>
#include <nlohmann/json.hpp>

#include "server/base/version.h"
#include "server/spec/contract.h"
#include "server/spec/limits.h"

namespace kiln {

namespace {

using Json = nlohmann::ordered_json;

/// null for 0.
Json time_text(std::int64_t unix_ms) {
    if (unix_ms == 0) return nullptr;
    return time_words(unix_ms);
}

/// Of slices and atlas: only their canonical text has this field.
bool has_sidecar(const JobRecord& job) { return job.spec.find("\"measured\":{") != job.spec.npos; }

Json links(const JobRecord& job) {
    const std::string self = "/v1/jobs/" + job.id;
    Json links = {{"self", self}, {"events", self + "/events"}};
    if (job.state == JobState::done) {
        links["image"] = self + "/image." + job.image_extension;
        links["report"] = self + "/report";
        if (has_sidecar(job)) links["sidecar"] = self + "/sidecar";
    }
    return links;
}

Json job_json(const JobRecord& job, bool cached) {
    Json error = nullptr;
    if (!job.error_code.empty()) error = {{"code", job.error_code}, {"detail", job.error_detail}};
    Json standard_error = nullptr;
    if (job.standard_error_max) standard_error = *job.standard_error_max;
    return {{"id", job.id},
            {"state", to_word(job.state)},
            {"progress", job.progress},
            {"standard_error_max", standard_error},
            {"cached", cached},
            {"error", error},
            {"links", links(job)},
            {"attempts", job.attempts},
            {"note", job.note},
            {"created", time_text(job.created_ms)},
            {"started", time_text(job.started_ms)},
            {"finished", time_text(job.finished_ms)}};
}

Json with_job(Json document, const JobRecord& job) {
    document["job"] = Json::parse(job.spec);
    return document;
}

/// Notes and details may quote a driver: whatever is not UTF-8 in them is replaced.
std::string text_of(const Json& json) {
    return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

/// The words that a schema of the contract allows, following one $ref; empty when it is no closed
/// set.
nlohmann::json words_of(const nlohmann::json& schema) {
    if (schema.contains("$ref")) {
        const std::string pointer = schema.at("$ref").get<std::string>().substr(1);
        return words_of(contract().at(nlohmann::json::json_pointer(pointer)));
    }
    if (schema.contains("enum")) return schema.at("enum");
    if (schema.contains("items")) return words_of(schema.at("items"));
    return nlohmann::json::array();
}

/// {field: [words]} of every closed set among a schema's properties, two levels deep.
Json values_of(const nlohmann::json& schema, int depth) {
    Json values = Json::object();
    if (schema.contains("$ref")) {
        const std::string pointer = schema.at("$ref").get<std::string>().substr(1);
        return values_of(contract().at(nlohmann::json::json_pointer(pointer)), depth);
    }
    if (!schema.contains("properties")) return values;
    for (const auto& [name, property] : schema.at("properties").items()) {
        if (const nlohmann::json words = words_of(property); !words.empty())
            values[name] = words;
        else if (depth > 0)
            if (Json inner = values_of(property, depth - 1); !inner.empty()) values[name] = inner;
    }
    return values;
}

Json limits_of(const Settings& settings, const Bounds& bounds) {
    Json all = Json::parse(limits_json());
    for (const Bound& bound : bounds)
        all[std::string(bound.name)] = {
            {"value", bound.value}, {"unit", bound.unit}, {"description", bound.description}};
    for (const Setting& setting : settings_table()) {
        const auto* number = std::get_if<std::int64_t Settings::*>(&setting.field);
        if (number == nullptr || setting.reader == Reader::supervised) continue;
        all[std::string(setting.name)] = {
            {"value", settings.*(*number)}, {"unit", setting.unit}, {"description", setting.help}};
    }
    return all;
}

}  // namespace

std::string time_words(std::int64_t unix_ms) {
    const auto seconds = static_cast<std::time_t>(unix_ms / 1000);
    std::tm parts{};
    gmtime_r(&seconds, &parts);
    std::array<char, 32> text{};
    std::array<char, 48> full{};
    std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%S", &parts);
    std::snprintf(full.data(), full.size(), "%s.%03dZ", text.data(),
                  static_cast<int>(unix_ms % 1000));
    return full.data();
}

std::string job_document(const JobRecord& job, bool cached, bool complete) {
    Json document = job_json(job, cached);
    return text_of(complete ? with_job(std::move(document), job) : document);
}

std::string page_document(const JobPage& page) {
    Json jobs = Json::array();
    for (const JobRecord& job : page.jobs)
        jobs.push_back(with_job(job_json(job, job.state == JobState::done), job));
    Json next = nullptr;
    if (!page.next_cursor.empty()) next = page.next_cursor;
    return text_of({{"jobs", jobs}, {"next_cursor", next}});
}

std::string batch_document(const std::vector<HttpResponse>& answers) {
    Json jobs = Json::array();
    for (const HttpResponse& answer : answers)
        jobs.push_back({{"status", answer.status},
                        {answer.status < 400 ? "job" : "problem", Json::parse(answer.body)}});
    return text_of({{"jobs", jobs}});
}

std::string capabilities_document(const Service& service) {
    const ServiceParts& parts = service.parts();
    Json workers = Json::array();
    for (const WorkerStatus& worker : parts.workers()) {
        const Json devices =
            worker.devices_json.empty() ? Json::array() : Json::parse(worker.devices_json);
        workers.push_back({{"name", worker.name}, {"alive", worker.alive}, {"devices", devices}});
    }
    const std::size_t slash = parts.engine.rfind('/');
    const nlohmann::json& job = contract().at("components").at("schemas").at("Job");
    return text_of({{"version", kVersion},
                    {"kernel_digest", parts.engine.substr(0, slash)},
                    {"encoder_revision", parts.engine.substr(slash + 1)},
                    {"reader_revision", parts.readers},
                    {"device", parts.settings.device},
                    {"limits", limits_of(parts.settings, parts.bounds)},
                    {"values", values_of(job, 2)},
                    {"workers", workers},
                    {"openapi", "/openapi.json"}});
}

HttpResponse json_response(int status, std::string body) {
    HttpResponse response;
    response.status = status;
    response.content_type = "application/json";
    response.body = std::move(body);
    return response;
}

}  // namespace kiln
