// SPDX-License-Identifier: Apache-2.0
#include "server/compute/report.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "server/base/error.h"

namespace kiln {
namespace {

using Json = nlohmann::ordered_json;  // fields in the contract's order

Json number(const char* field, double value) {
    // nlohmann writes a non-finite number as null, which in a report means "does not exist".
    if (!std::isfinite(value))
        throw Error("non_finite", std::string("the report's ") + field + " is not a finite number");
    return value;
}

Json number(const char* field, const std::optional<double>& value) {
    return value ? number(field, *value) : Json(nullptr);
}

Json errors(const std::vector<ChannelError>& channels) {
    Json out = Json::object();
    for (const auto& e : channels) {
        if (out.contains(e.quantity))
            throw Error("duplicate_quantity", "the report has two errors for " + e.quantity);
        out[e.quantity] = {
            {"standard_error_rms", number("standard_error_rms", e.standard_error_rms)},
            {"standard_error_max", number("standard_error_max", e.standard_error_max)},
            {"reference_rms", number("reference_rms", e.reference_rms)},
            {"reference_max", number("reference_max", e.reference_max)},
            {"reference_texels", e.reference_texels ? Json(*e.reference_texels) : Json(nullptr)},
            {"reconstruction_max", number("reconstruction_max", e.reconstruction_max)},
            {"quantisation_max", number("quantisation_max", e.quantisation_max)},
        };
    }
    return out;
}

Json trace(const std::vector<TraceRow>& rows) {
    Json out = Json::array();
    for (const auto& row : rows)
        out.push_back({
            {"sample_count", row.sample_count},
            {"elapsed_s", number("elapsed_s", row.elapsed_s)},
            {"standard_error_rms", number("standard_error_rms", row.standard_error_rms)},
            {"standard_error_max", number("standard_error_max", row.standard_error_max)},
        });
    return out;
}

Json left_out(const std::vector<LeftOut>& items) {
    Json out = Json::array();
    for (const auto& item : items) out.push_back({{"what", item.what}, {"why", item.why}});
    return out;
}

}  // namespace

std::string to_json(const Report& r) {
    const Json fallback = r.device.fallback ? Json(*r.device.fallback) : Json(nullptr);
    const Json out = {
        {"job", r.job},
        {"status", r.status},
        {"device",
         {{"backend", r.device.backend},
          {"name", r.device.name},
          {"numerics", r.device.numerics},
          {"fallback", fallback}}},
        {"samples",
         {{"per_texel", r.samples_per_texel},
          {"total", r.samples_total},
          {"replicates", r.replicates}}},
        {"run_time_s",
         {{"queued", number("run_time_s.queued", r.run_time_s.queued)},
          {"compile", number("run_time_s.compile", r.run_time_s.compile)},
          {"integrate", number("run_time_s.integrate", r.run_time_s.integrate)},
          {"assemble", number("run_time_s.assemble", r.run_time_s.assemble)},
          {"reference", number("run_time_s.reference", r.run_time_s.reference)},
          {"encode", number("run_time_s.encode", r.run_time_s.encode)},
          {"total", number("run_time_s.total", r.run_time_s.total)}}},
        {"error", errors(r.error)},
        {"trace", trace(r.trace)},
        {"work",
         {{"brdf_evaluations", r.work.brdf_evaluations},
          {"fresnel_evaluations", r.work.fresnel_evaluations},
          {"multiscatter_evaluations", r.work.multiscatter_evaluations}}},
        {"left_out", left_out(r.left_out)},
        {"warnings", r.warnings.empty() ? Json::array() : Json(r.warnings)},
    };
    // Device names come from drivers: bytes that are not UTF-8 become U+FFFD instead of failing the
    // job.
    return out.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace kiln
