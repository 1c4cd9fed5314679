// SPDX-License-Identifier: Apache-2.0
#include "server/spec/settings.h"

#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>

#include "server/spec/json_text.h"
#include "server/spec/limits.h"
#include "server/spec/spec.h"

namespace kiln {
namespace {

using Json = nlohmann::json;

[[noreturn]] void refuse(const std::string& setting, const std::string& message) {
    throw Malformed("the setting " + in_quotes(setting) + " " + message, {{"", message}});
}

std::vector<std::string> split_path(const std::string& setting, std::string_view path) {
    std::vector<std::string> names;
    for (std::size_t start = 0; start <= path.size();) {
        const std::size_t end = std::min(path.find('.', start), path.size());
        names.emplace_back(path.substr(start, end - start));
        if (names.back().empty())
            refuse(setting, "has an empty name; allowed: field=value or object.field=value");
        start = end + 1;
    }
    if (names.size() > static_cast<std::size_t>(limits().depth_max))
        refuse(setting, "nests deeper than " + std::to_string(limits().depth_max) + " levels");
    return names;
}

Json read_value(const std::string& setting, const std::string& text) {
    const bool looks_like_json =
        text.starts_with('[') || text.starts_with('{') || text.starts_with('"');
    if (!looks_like_json && !Json::accept(text)) return text;
    try {
        return parse_json(text, {limits().job_bytes_max, limits().depth_max});
    } catch (const Malformed& error) {
        refuse(setting, "has a value that cannot be read: " + error.problems.at(0).message);
    }
}

Json& member(const std::string& setting, Json& parent, const std::string& name) {
    if (parent.is_null()) parent = Json::object();
    if (parent.is_object()) return parent[name];
    if (!parent.is_array())
        refuse(setting, "leads through a value that is no object: nothing can be called " +
                            in_quotes(name) + " there");
    std::size_t index = 0;
    const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), index);
    if (error != std::errc() || end != name.data() + name.size() || index >= parent.size())
        refuse(setting, "names entry " + in_quotes(name) + " of an array that has " +
                            std::to_string(parent.size()));
    return parent[index];
}

void apply(Json& document, const std::string& setting) {
    const std::size_t equals = setting.find('=');
    if (equals == std::string::npos) refuse(setting, "has no '='; allowed: field=value");
    Json* place = &document;
    for (const std::string& name : split_path(setting, std::string_view(setting).substr(0, equals)))
        place = &member(setting, *place, name);
    *place = read_value(setting, setting.substr(equals + 1));
    try {
        static_cast<void>(document.dump());
    } catch (const Json::exception&) {
        refuse(setting, "is not UTF-8");
    }
}

}  // namespace

std::string apply_settings(std::string_view job_text, const std::vector<std::string>& settings) {
    Json document = parse_json(job_text, {limits().job_bytes_max, limits().depth_max});
    for (const std::string& setting : settings) apply(document, setting);
    return document.dump();
}

}  // namespace kiln
