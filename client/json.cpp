// SPDX-License-Identifier: Apache-2.0
#include "client/json.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "server/compute/devices_json.h"
#include "server/spec/kinds.h"
#include "server/spec/spec.h"
#include "server/spec/words.h"

namespace kiln::client {

namespace {

using Json = nlohmann::ordered_json;

/// Bytes that are not UTF-8 (a foreign file's metadata) become U+FFFD rather than an exception.
std::string dump(const Json& json, int indent = 2) {
    return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

/// Deeper than anything in the contract; nlohmann's destructor and copies recurse.
constexpr int kDepthMax = 64;

std::optional<Json> parse(std::string_view text) {
    bool too_deep = false;
    const auto guard = [&](int depth, Json::parse_event_t, Json&) {
        too_deep |= depth > kDepthMax;
        return depth <= kDepthMax;
    };
    Json json = Json::parse(text.begin(), text.end(), guard, false);
    if (json.is_discarded() || too_deep) return std::nullopt;
    return json;
}

std::string text_at(const Json& object, const char* key) {
    const auto found = object.find(key);
    return found != object.end() && found->is_string() ? found->get<std::string>() : "";
}

std::optional<double> number_at(const Json& object, const char* key) {
    const auto found = object.find(key);
    if (found == object.end() || !found->is_number()) return std::nullopt;
    return found->get<double>();
}

std::optional<std::int64_t> integer_at(const Json& object, const char* key) {
    const auto found = object.find(key);
    if (found == object.end() || !found->is_number_integer()) return std::nullopt;
    return found->get<std::int64_t>();
}

const Json& object_at(const Json& object, const char* key) {
    static const Json empty = Json::object();
    const auto found = object.find(key);
    return found != object.end() && found->is_object() ? *found : empty;
}

const Json& array_at(const Json& object, const char* key) {
    static const Json empty = Json::array();
    const auto found = object.find(key);
    return found != object.end() && found->is_array() ? *found : empty;
}

std::optional<JobStatus> job_status(const Json& json) {
    if (!json.is_object()) return std::nullopt;
    JobStatus job;
    job.id = text_at(json, "id");
    job.state = text_at(json, "state");
    if (job.id.empty() || job.state.empty()) return std::nullopt;
    job.progress = number_at(json, "progress").value_or(0);
    job.cached = json.value("cached", Json(false)) == Json(true);
    job.standard_error_max = number_at(json, "standard_error_max");
    job.error_code = text_at(object_at(json, "error"), "code");
    job.error_detail = text_at(object_at(json, "error"), "detail");
    job.created = text_at(json, "created");
    job.kind = text_at(object_at(json, "job"), "kind");
    for (const Json& quantity : array_at(object_at(json, "job"), "quantities"))
        if (quantity.is_string()) job.quantities.push_back(quantity.get<std::string>());
    job.document = dump(json, -1);
    return job;
}

ChannelError channel_error(const std::string& quantity, const Json& json) {
    return {.quantity = quantity,
            .standard_error_rms = number_at(json, "standard_error_rms"),
            .standard_error_max = number_at(json, "standard_error_max"),
            .reference_rms = number_at(json, "reference_rms"),
            .reference_max = number_at(json, "reference_max"),
            .reconstruction_max = number_at(json, "reconstruction_max"),
            .quantisation_max = number_at(json, "quantisation_max"),
            .reference_texels = integer_at(json, "reference_texels")};
}

}  // namespace

std::optional<JobStatus> read_job_status(std::string_view text) {
    const auto json = parse(text);
    return json ? job_status(*json) : std::nullopt;
}

std::optional<JobList> read_job_list(std::string_view text) {
    const auto json = parse(text);
    if (!json || !json->is_object() || !json->contains("jobs")) return std::nullopt;
    JobList list{.jobs = {}, .next_cursor = text_at(*json, "next_cursor")};
    for (const Json& entry : array_at(*json, "jobs")) {
        auto job = job_status(entry);
        if (!job) return std::nullopt;
        list.jobs.push_back(std::move(*job));
    }
    return list;
}

std::optional<ProblemDocument> read_problem(std::string_view text) {
    const auto json = parse(text);
    if (!json || !json->is_object()) return std::nullopt;
    ProblemDocument problem{
        .code = text_at(*json, "code"), .detail = text_at(*json, "detail"), .problems = {}};
    if (problem.detail.empty()) problem.detail = text_at(*json, "title");
    if (problem.code.empty() && problem.detail.empty()) return std::nullopt;
    for (const Json& entry : array_at(*json, "problems"))
        if (entry.is_object())
            problem.problems.push_back({text_at(entry, "pointer"), text_at(entry, "message")});
    return problem;
}

std::optional<Report> read_report(std::string_view text) {
    const auto json = parse(text);
    if (!json || !json->is_object()) return std::nullopt;
    Report report;
    report.job = text_at(*json, "job");
    report.status = text_at(*json, "status");
    const Json& device = object_at(*json, "device");
    report.device = {.backend = text_at(device, "backend"),
                     .name = text_at(device, "name"),
                     .numerics = text_at(device, "numerics"),
                     .fallback = {}};
    if (const std::string why = text_at(device, "fallback"); !why.empty())
        report.device.fallback = why;
    const Json& samples = object_at(*json, "samples");
    report.samples_per_texel =
        static_cast<std::int64_t>(number_at(samples, "per_texel").value_or(0));
    const Json& time = object_at(*json, "run_time_s");
    report.run_time_s = {.queued = number_at(time, "queued").value_or(0),
                         .compile = number_at(time, "compile").value_or(0),
                         .integrate = number_at(time, "integrate").value_or(0),
                         .assemble = number_at(time, "assemble").value_or(0),
                         .reference = number_at(time, "reference").value_or(0),
                         .encode = number_at(time, "encode").value_or(0),
                         .total = number_at(time, "total").value_or(0)};
    for (const auto& [quantity, channel] : object_at(*json, "error").items())
        if (channel.is_object()) report.error.push_back(channel_error(quantity, channel));
    const Json& work = object_at(*json, "work");
    const auto count = [&](const char* name) {
        return static_cast<std::uint64_t>(std::max(0.0, number_at(work, name).value_or(0)));
    };
    report.work = {.brdf_evaluations = count("brdf_evaluations"),
                   .fresnel_evaluations = count("fresnel_evaluations"),
                   .multiscatter_evaluations = count("multiscatter_evaluations")};
    for (const Json& entry : array_at(*json, "left_out"))
        if (entry.is_object())
            report.left_out.push_back({text_at(entry, "what"), text_at(entry, "why")});
    for (const Json& warning : array_at(*json, "warnings"))
        if (warning.is_string()) report.warnings.push_back(warning.get<std::string>());
    return report;
}

std::optional<std::vector<BatchEntry>> read_batch_answer(std::string_view text) {
    const auto json = parse(text);
    if (!json || !json->is_object()) return std::nullopt;
    std::vector<BatchEntry> entries;
    for (const Json& entry : array_at(*json, "jobs")) {
        if (!entry.is_object()) return std::nullopt;
        const auto status = static_cast<long>(number_at(entry, "status").value_or(0));
        entries.push_back({status, dump(object_at(entry, status < 400 ? "job" : "problem"), -1)});
    }
    return entries;
}

std::optional<MeasurementAnswer> read_measurement_answer(std::string_view text) {
    const auto json = parse(text);
    if (!json || !json->is_object()) return std::nullopt;
    MeasurementAnswer answer{.id = text_at(*json, "id"),
                             .format = text_at(*json, "format"),
                             .title = text_at(*json, "title"),
                             .unfit = text_at(*json, "unfit")};
    if (answer.id.empty()) return std::nullopt;
    return answer;
}

std::string measurements_json(const std::vector<std::string>& documents) {
    Json list = Json::array();
    for (const std::string& document : documents)
        if (auto json = parse(document)) list.push_back(std::move(*json));
    return dump({{"measurements", list}});
}

Makers read_makers(std::string_view text) {
    const auto json = parse(text);
    if (!json || !json->is_object()) return {};
    const std::string digest = text_at(*json, "kernel_digest");
    if (digest.empty()) return {};
    Makers makers{digest + "/" + text_at(*json, "encoder_revision"), ""};
    if (const auto readers = integer_at(*json, "reader_revision"))
        makers.measured = makers.tables + "/" + std::to_string(*readers);
    return makers;
}

std::vector<SliceError> read_lookup_errors(std::string_view sidecar, std::size_t cell) {
    const auto json = parse(sidecar);
    std::vector<SliceError> errors;
    if (!json || !json->is_object()) return errors;
    const Json& cells = array_at(*json, "materials");
    if (cell >= cells.size() || !cells[cell].is_object()) return errors;
    for (const Json& slice : array_at(cells[cell], "slices"))
        if (slice.is_object())
            errors.push_back({number_at(slice, "theta_in_deg").value_or(0),
                              number_at(slice, "lookup_error").value_or(0)});
    return errors;
}

std::string batch_json(const std::vector<std::string>& jobs) {
    Json list = Json::array();
    for (const std::string& job : jobs) list.push_back(Json::parse(job));
    return dump({{"jobs", list}}, -1);
}

bool is_capabilities(std::string_view text) {
    const auto json = parse(text);
    return json && json->is_object() && json->contains("version") && json->contains("limits");
}

bool lacks_output_format(std::string_view job_text) {
    const auto json = parse(job_text);
    if (!json || !json->is_object()) return false;
    const Json word = json->value("kind", Json("lut"));
    const auto kind = word.is_string() ? from_word<Kind>(word.get<std::string>()) : std::nullopt;
    if (!kind || !is_read(*kind, "output")) return false;  // studies and views are PNG
    const auto output = json->find("output");
    return output == json->end() || (output->is_object() && !output->contains("format"));
}

std::string as_study(std::string_view job_text, Kind kind) {
    auto json = parse(job_text);
    if (!json || !json->is_object()) return std::string(job_text);
    if (json->value("kind", Json("lut")) == to_word(kind)) return std::string(job_text);
    Json study = {{"kind", to_word(kind)}};
    for (const auto& [field, value] : json->items())
        if (field != "kind" && (is_read(kind, field) || !is_read(Kind::lut, field)))
            study[field] = value;
    return dump(study);
}

std::string problem_json(const ProblemDocument& problem) {
    Json list = Json::array();
    for (const Problem& entry : problem.problems)
        list.push_back({{"pointer", entry.pointer}, {"message", entry.message}});
    return dump({{"code", problem.code}, {"detail", problem.detail}, {"problems", list}});
}

std::string info_json(const Decoded& file, const std::vector<ChannelStatistics>& statistics,
                      const std::vector<std::string>& convention) {
    Json channels = Json::array();
    for (const ChannelStatistics& channel : statistics) {
        Json entry = {{"name", channel.name}};
        const bool any = channel.finite_count != 0;
        entry["min"] = any ? Json(channel.min) : Json(nullptr);
        entry["max"] = any ? Json(channel.max) : Json(nullptr);
        entry["mean"] = any ? Json(channel.mean) : Json(nullptr);
        entry["nan_count"] = channel.nan_count;
        entry["infinite_count"] = channel.infinite_count;
        channels.push_back(std::move(entry));
    }
    Json metadata = Json::object();
    for (const auto& [key, value] : file.metadata) metadata[key] = value;
    return dump({{"format", file.format},
                 {"pixel", file.pixel},
                 {"resolution", {file.table.width, file.table.height}},
                 {"channels", channels},
                 {"convention", convention},
                 {"metadata", metadata}});
}

std::string difference_json(const Comparison& comparison, double max_error) {
    Json channels = Json::object();
    for (const ChannelDifference& channel : comparison.channels)
        channels[channel.name] = {{"max", channel.max},
                                  {"rms", channel.rms},
                                  {"texel", {channel.x, channel.y}},
                                  {"values", {channel.a, channel.b}},
                                  {"incomparable_count", channel.incomparable_count}};
    Json json = {{"within", comparison.within(max_error)}, {"max_error", max_error}};
    json["mismatch"] = comparison.mismatch.empty() ? Json(nullptr) : Json(comparison.mismatch);
    json["channels"] = channels;
    return dump(json);
}

std::string advice_json(const std::vector<Candidate>& candidates, double max_error) {
    Json list = Json::array();
    for (const Candidate& candidate : candidates)
        list.push_back({{"job", Json::parse(canonical(candidate.job))},
                        {"bytes", candidate.bytes},
                        {"reconstruction_max", candidate.reconstruction},
                        {"quantisation_max", candidate.quantisation},
                        {"integration_max", candidate.integration},
                        {"total_max", candidate.total()}});
    return dump({{"max_error", max_error}, {"candidates", list}});
}

std::string devices_json(const std::vector<DeviceInfo>& devices) {
    return dump({{"devices", Json::parse(to_json(devices))}});
}

std::string jobs_json(const std::vector<JobStatus>& jobs) {
    Json list = Json::array();
    for (const JobStatus& job : jobs)
        if (auto json = parse(job.document)) list.push_back(std::move(*json));
    return dump({{"jobs", list}});
}

}  // namespace kiln::client
