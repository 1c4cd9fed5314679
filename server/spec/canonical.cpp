// SPDX-License-Identifier: Apache-2.0
#include <nlohmann/json.hpp>

#include "server/base/sha256.h"
#include "server/spec/contract.h"
#include "server/spec/kinds.h"
#include "server/spec/measured_fields.h"
#include "server/spec/models.h"
#include "server/spec/schema.h"
#include "server/spec/spec.h"
#include "server/spec/words.h"

namespace kiln {
namespace {

using Json = nlohmann::json;

/// A job of nothing but defaults. Fields that a JobSpec does not hold have one allowed value, which
/// is this.
const Json& defaults() {
    static const Json document = [] {
        ProblemList none(1);
        const Json minimal = {{"quantities", {to_word(Quantity{})}}};
        return walk_schema(contract(), contract()["components"]["schemas"]["Job"], minimal, none);
    }();
    return document;
}

Json to_json(const Axis& axis) {
    if (!axis.values.empty())
        return {{"parameter", to_word(axis.parameter)}, {"values", axis.values}};
    return {{"parameter", to_word(axis.parameter)},
            {"mapping", to_word(axis.mapping)},
            {"grid", to_word(axis.grid)},
            {"flip", axis.flip},
            {"range", {axis.lo, axis.hi}}};
}

Json layout_of(const JobSpec& job) {
    if (job.layout != "custom") return job.layout;
    Json layout = {{"x", to_json(job.axes.at(0))}};
    if (job.axes.size() > 1) layout["y"] = to_json(job.axes[1]);
    if (job.axes.size() > 2) layout["z"] = to_json(job.axes[2]);
    return layout;
}

}  // namespace

std::string canonical(const JobSpec& job) {
    Json document = defaults();
    document["kind"] = to_word(job.kind);
    Json quantities = Json::array();
    for (const Quantity quantity : job.quantities) quantities.push_back(to_word(quantity));
    document["quantities"] = std::move(quantities);
    document["resolution"] = job.resolution;
    document["layout"] = layout_of(job);
    document["sample_count"] = job.sample_count;
    if (job.target_error) document["target_error"] = *job.target_error;
    if (job.time_budget_s) document["time_budget_s"] = *job.time_budget_s;
    document["integrator"] = to_word(job.integrator);
    document["sampler"] = to_word(job.sampler);
    write_models(job, document);
    document["precision"] = to_word(job.precision);
    document["device"] = to_word(job.device);
    document["seed"] = job.seed;
    if (is_measured(job.kind)) document["measured"] = measured_json(job);
    document["output"] = {{"format", to_word(job.format)}, {"pixel", to_word(job.pixel)}};
    const Json whole = document;
    for (const auto& [field, value] : whole.items())
        if (!is_read(job.kind, field)) document.erase(field);
    return document.dump(-1, ' ', /*ensure_ascii=*/true);  // names of materials; files hold ASCII
}

std::string job_id(const JobSpec& job) { return sha256_hex("kiln/job/1\n" + canonical(job)); }

}  // namespace kiln
