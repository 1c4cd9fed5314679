// SPDX-License-Identifier: Apache-2.0
#include "server/scene/plan_options.h"

#include <charconv>
#include <nlohmann/json.hpp>

#include "server/scene/table_jobs.h"
#include "server/spec/contract.h"
#include "server/spec/schema.h"
#include "server/spec/words.h"

namespace kiln {

namespace {

using Json = nlohmann::json;

/// "64" is a number where it looks like one; names of scenes stay texts.
Json value_of(const std::string& name, const std::string& text) {
    if (name == "scene" || name == "variant") return text;
    std::int64_t number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error == std::errc() && end == text.data() + text.size()) return number;
    return text;
}

template <JobEnum E>
E word(const Json& document, const char* name) {
    return from_word<E>(document.at(name).get_ref<const std::string&>()).value();
}

}  // namespace

PlanRequest read_plan_request(const std::map<std::string, std::string>& options) {
    Json given = Json::object();
    for (const auto& [name, text] : options) given[name] = value_of(name, text);
    ProblemList problems(1);
    const Json& schema = contract()["components"]["schemas"]["PlanOptions"];
    const Json document = walk_schema(contract(), schema, given, problems);
    if (!problems.empty()) {
        const Problem first = problems.take().front();
        throw Error("bad_query",
                    first.pointer.substr(first.pointer.empty() ? 0 : 1) + ": " + first.message);
    }
    PlanRequest request;
    request.choice = {document.value("scene", ""), document.value("variant", "")};
    PlanOptions& result = request.options;
    result.resolution = document.at("resolution").get<std::int64_t>();
    result.sample_count = document.at("sample_count").get<std::int64_t>();
    result.multiscatter = word<Multiscatter>(document, "multiscatter");
    result.diffuse = word<DiffuseModel>(document, "diffuse");
    result.device = word<DeviceChoice>(document, "device");
    result.format = word<ImageFormat>(document, "format");
    result.pixel = document.contains("pixel")          ? word<PixelType>(document, "pixel")
                   : result.format == ImageFormat::exr ? PixelType::half
                                                       : PixelType::uint16;
    table_job(TableKind::specular, {0, 1}, result, {});  // throws what no job can be
    return request;
}

}  // namespace kiln
