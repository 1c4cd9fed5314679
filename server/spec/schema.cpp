// SPDX-License-Identifier: Apache-2.0
#include "server/spec/schema.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>

#include "server/spec/json_text.h"
#include "server/spec/phrases.h"

namespace kiln {
namespace {

using Json = nlohmann::json;

const Json& resolve(const Json& contract, const Json& schema) {
    const Json* current = &schema;
    while (current->contains("$ref")) {
        const auto& reference = current->at("$ref").get_ref<const std::string&>();
        current = &contract.at(Json::json_pointer(reference.substr(1)));  // "#/…"
    }
    return *current;
}

bool is_integral(const Json& value) {
    if (value.is_number_integer()) return true;
    return value.is_number_float() && std::trunc(value.get<double>()) == value.get<double>();
}

bool has_type(const Json& value, std::string_view type) {
    if (type == "null") return value.is_null();
    if (type == "boolean") return value.is_boolean();
    if (type == "string") return value.is_string();
    if (type == "array") return value.is_array();
    if (type == "object") return value.is_object();
    if (type == "number") return value.is_number();
    return type == "integer" && is_integral(value);
}

bool has_any_type(const Json& value, const Json& type) {
    const auto names = type_names(type);
    return std::any_of(names.begin(), names.end(),
                       [&](const auto& name) { return has_type(value, name); });
}

/// What becomes of members that a schema allows and does not name.
enum class Others { kept, left_out };

class Walker {
  public:
    Walker(const Json& contract, ProblemList& problems, Others others)
        : contract_(contract), problems_(problems), others_(others) {}

    Json visit(const Json& reference, const Json& value, const std::string& pointer) {
        const Json& schema = resolve(contract_, reference);
        if (schema.contains("oneOf")) return visit_branch(schema, value, pointer);
        if (!allowed_value(schema, value, pointer)) return value;
        if (schema.contains("type") && !has_any_type(value, schema["type"])) {
            const Json& later = later_of(schema, "type");
            problems_.add(pointer, later.is_array() && has_any_type(value, later)
                                       ? type_phrase(later) + " is not supported yet; allowed: " +
                                             type_phrase(schema["type"])
                                       : "is " + found(value) + "; must be " +
                                             type_phrase(schema["type"]) + range_phrase(schema));
            return value;
        }
        if (value.is_number()) return visit_number(schema, value, pointer);
        if (value.is_string()) check_length(schema, value, pointer);
        if (value.is_array()) return visit_array(schema, value, pointer);
        if (value.is_object()) return visit_object(schema, value, pointer);
        return value;
    }

  private:
    /// What stands at `keyword`, null when nothing does.
    static const Json& entry(const Json& schema, const char* keyword) {
        static const Json kNothing;
        const auto found_entry = schema.find(keyword);
        return found_entry == schema.end() ? kNothing : *found_entry;
    }
    static const Json& later_of(const Json& schema, const char* keyword) {
        return entry(entry(schema, "x-kiln-later"), keyword);
    }
    static std::vector<std::string> strings_of(const Json& values) {
        std::vector<std::string> strings;
        for (const Json& value : values) {
            if (value.is_string()) strings.push_back(value);
        }
        return strings;
    }

    Json visit_branch(const Json& schema, const Json& value, const std::string& pointer) {
        std::string types;
        for (const Json& branch : schema["oneOf"]) {
            const Json& target = resolve(contract_, branch);
            if (value.is_array() && target["type"] == "array")
                return visit_array(target, value, pointer, types);
            if (has_any_type(value, target["type"])) return visit(target, value, pointer);
            types += (types.empty() ? "" : " or ") + type_phrase(target["type"]);
        }
        problems_.add(pointer, "is " + found(value) + "; must be " + types);
        return value;
    }

    bool allowed_value(const Json& schema, const Json& value, const std::string& pointer) {
        if (schema.contains("const") && value != schema["const"]) {
            problems_.add(pointer,
                          found(value) + " is not allowed; allowed: " + found(schema["const"]));
            return false;
        }
        if (!schema.contains("enum")) return true;
        const Json& allowed = schema["enum"];
        if (std::find(allowed.begin(), allowed.end(), value) != allowed.end()) return true;
        const Json& later = later_of(schema, "enum");
        const bool is_later = std::find(later.begin(), later.end(), value) != later.end();
        std::string message = found(value) +
                              (is_later ? " is not supported yet" : " is not allowed") +
                              "; allowed: " + list_of(allowed);
        if (value.is_string() && !is_later)
            message += suggestion(value.get_ref<const std::string&>(), strings_of(allowed));
        problems_.add(pointer, message);
        return false;
    }

    static std::string range_phrase(const Json& schema) {
        if (!schema.contains("minimum") || !schema.contains("maximum")) return "";
        return " in " + schema["minimum"].dump() + "…" + schema["maximum"].dump() +
               unit_phrase(schema);
    }
    static std::string unit_phrase(const Json& schema) {
        return schema.contains("x-kiln-unit") ? " " + schema["x-kiln-unit"].get<std::string>() : "";
    }

    Json visit_number(const Json& schema, const Json& value, const std::string& pointer) {
        // long double has 64 bits of precision at least where int64 and uint64 have to compare
        // exactly.
        const auto exact = [](const Json& number) -> long double {
            if (number.is_number_unsigned())
                return static_cast<long double>(number.get<std::uint64_t>());
            if (number.is_number_integer())
                return static_cast<long double>(number.get<std::int64_t>());
            return number.get<double>();
        };
        const long double number = exact(value);
        const bool low = schema.contains("minimum") && number < exact(schema["minimum"]);
        const bool high = schema.contains("maximum") && number > exact(schema["maximum"]);
        if (low || high) {
            const std::string range = range_phrase(schema);
            const std::string bound = low ? " at least " + schema["minimum"].dump()
                                          : " at most " + schema["maximum"].dump();
            problems_.add(pointer, "is " + value.dump() + "; must be" +
                                       (range.empty() ? bound + unit_phrase(schema) : range));
            return value;
        }
        constexpr double kExactIntegers = 9007199254740992.0;  // 2^53
        if (entry(schema, "type") == "integer" && value.is_number_float() &&
            std::abs(value.get<double>()) <= kExactIntegers)
            return static_cast<std::int64_t>(value.get<double>());
        return value;
    }

    void check_length(const Json& schema, const Json& value, const std::string& pointer) {
        const auto& text = value.get_ref<const std::string&>();
        // JSON Schema counts characters: every byte that does not continue a UTF-8 sequence.
        const auto length =
            static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char c) {
                return (static_cast<unsigned char>(c) & 0xC0) != 0x80;
            }));
        check_count(schema, "minLength", "maxLength", length, "characters", pointer);
    }

    bool check_count(const Json& schema, const char* low, const char* high, std::size_t count,
                     const std::string& unit, const std::string& pointer,
                     const std::string& instead = "") {
        const std::size_t least = schema.value(low, std::size_t{0});
        const std::size_t most = schema.value(high, std::size_t{SIZE_MAX});
        if (count >= least && count <= most) return true;
        const std::string allowed = most == SIZE_MAX ? "at least " + std::to_string(least)
                                    : least == most
                                        ? std::to_string(least)
                                        : std::to_string(least) + "…" + std::to_string(most);
        const Json& later = later_of(schema, high);
        const bool is_later =
            later.is_number() && count > most && count <= later.get<std::size_t>();
        problems_.add(pointer,
                      "has " + std::to_string(count) + " " + unit +
                          (is_later ? ", which is not supported yet; allowed: " : "; allowed: ") +
                          (instead.empty() ? "" : instead + " or ") + allowed);
        return false;
    }

    /// `instead`: what is allowed in place of an array, where anything is.
    Json visit_array(const Json& schema, const Json& value, const std::string& pointer,
                     const std::string& instead = "") {
        if (!check_count(schema, "minItems", "maxItems", value.size(), "entries", pointer, instead))
            return value;
        Json result = Json::array();
        for (std::size_t i = 0; i < value.size(); ++i) {
            const std::string place = join_pointer(pointer, std::to_string(i));
            result.push_back(schema.contains("items") ? visit(schema["items"], value[i], place)
                                                      : value[i]);
            if (!schema.value("uniqueItems", false)) continue;
            const auto end = value.begin() + static_cast<std::ptrdiff_t>(i);
            const auto first = std::find(value.begin(), end, value[i]);
            if (first != end)
                problems_.add(place,
                              found(value[i]) + " stands already at " +
                                  join_pointer(pointer, std::to_string(first - value.begin())) +
                                  "; every entry must differ");
        }
        return result;
    }

    Json visit_object(const Json& schema, const Json& value, const std::string& pointer) {
        const Json& properties = entry(schema, "properties");
        const Json& extra = entry(schema, "additionalProperties");
        Json result = others_ == Others::kept ? value : Json::object();
        for (const Json& name : entry(schema, "required")) {
            const auto& text = name.get_ref<const std::string&>();
            if (!value.contains(text))
                problems_.add(join_pointer(pointer, text), "is required and missing");
        }
        for (const auto& [name, member] : value.items()) {
            const std::string place = join_pointer(pointer, name);
            if (properties.contains(name))
                result[name] = visit(properties[name], member, place);
            else if (extra.is_object())
                result[name] = visit(extra, member, place);
            else if (extra == false)
                refuse_name(schema, properties, name, place);
        }
        for (const auto& [name, property] : properties.items()) {
            const Json& target = resolve(contract_, property);
            if (!value.contains(name) && target.contains("default"))
                result[name] = visit(target, target["default"], join_pointer(pointer, name));
        }
        return result;
    }

    void refuse_name(const Json& schema, const Json& properties, const std::string& name,
                     const std::string& pointer) {
        if (problems_.full())
            return problems_.add(pointer, "");  // counted, its message is not needed
        std::vector<std::string> known;
        for (const auto& [word, property] : properties.items()) known.push_back(word);
        const Json& later = later_of(schema, "properties");
        const bool is_later = std::find(later.begin(), later.end(), Json(name)) != later.end();
        std::string message = "the field " + in_quotes(name) +
                              (is_later ? " is not supported yet" : " is unknown") +
                              "; allowed: " + list_of(Json(known));
        if (!is_later) message += suggestion(name, known);
        problems_.add(pointer, message);
    }

    const Json& contract_;
    ProblemList& problems_;
    Others others_;
};

[[noreturn]] void refuse_schema(const std::string& place, const std::string& message) {
    throw Error("contract", "api/openapi.json, " + place + ": " + message);
}

void check_branches(const Json& contract, const Json& schema, const std::string& place) {
    std::vector<std::string> seen;
    for (const Json& branch : schema["oneOf"]) {
        const Json& target = resolve(contract, branch);
        if (!target.contains("type")) refuse_schema(place, "a branch of oneOf has no type");
        for (const std::string& name : type_names(target["type"])) {
            if (std::find(seen.begin(), seen.end(), name) != seen.end())
                refuse_schema(place, "two branches of oneOf take the type " + name);
            seen.push_back(name);
        }
    }
}

}  // namespace

void ProblemList::add(const std::string& pointer, const std::string& message) {
    if (found_.size() < count_max_)
        found_.push_back({pointer, message});
    else
        ++left_out_;
}

bool ProblemList::sound(std::string_view pointer) const {
    if (left_out_ > 0) return false;  // where those are is not known
    const auto covers = [](std::string_view above, std::string_view below) {
        return below.starts_with(above) &&
               (below.size() == above.size() || below[above.size()] == '/');
    };
    return std::none_of(found_.begin(), found_.end(), [&](const Problem& problem) {
        return covers(problem.pointer, pointer) || covers(pointer, problem.pointer);
    });
}

std::vector<Problem> ProblemList::take() {
    if (left_out_ > 0)
        found_.push_back({"", "and " + std::to_string(left_out_) + " more problems"});
    return std::move(found_);
}

nlohmann::json walk_schema(const nlohmann::json& contract, const nlohmann::json& schema,
                           const nlohmann::json& instance, ProblemList& problems) {
    return Walker(contract, problems, Others::kept).visit(schema, instance, "");
}

nlohmann::json project_schema(const nlohmann::json& contract, const nlohmann::json& schema,
                              const nlohmann::json& instance, ProblemList& problems) {
    return Walker(contract, problems, Others::left_out).visit(schema, instance, "");
}

void check_schema(const nlohmann::json& contract, const nlohmann::json& schema,
                  const std::string& place) {
    constexpr std::array<std::string_view, 25> kKnown = {"$ref",
                                                         "type",
                                                         "enum",
                                                         "const",
                                                         "minimum",
                                                         "maximum",
                                                         "minItems",
                                                         "maxItems",
                                                         "items",
                                                         "minLength",
                                                         "maxLength",
                                                         "uniqueItems",
                                                         "required",
                                                         "properties",
                                                         "default",
                                                         "oneOf",
                                                         "additionalProperties",
                                                         "title",
                                                         "description",
                                                         "examples",
                                                         "x-kiln-later",
                                                         "x-kiln-unit",
                                                         "x-kiln-pixels",
                                                         "x-kiln-known",
                                                         "$comment"};
    if (!schema.is_object()) refuse_schema(place, "a schema must be an object");
    for (const auto& [keyword, value] : schema.items()) {
        if (std::find(kKnown.begin(), kKnown.end(), keyword) == kKnown.end())
            refuse_schema(place,
                          "the schema walker does not know the keyword " + in_quotes(keyword));
    }
    if (schema.contains("$ref")) {
        if (schema.size() > 1) refuse_schema(place, "draft 7 ignores what stands beside $ref");
        const auto& reference = schema["$ref"].get_ref<const std::string&>();
        if (!reference.starts_with("#/") ||
            !contract.contains(Json::json_pointer(reference.substr(1))))
            refuse_schema(place, "$ref leads nowhere: " + in_quotes(reference));
    }
    if (schema.contains("oneOf")) {
        check_branches(contract, schema, place);
        for (const Json& branch : schema["oneOf"]) check_schema(contract, branch, place + "/oneOf");
    }
    if (schema.contains("items")) check_schema(contract, schema["items"], place + "/items");
    if (schema.contains("additionalProperties") && !schema["additionalProperties"].is_boolean())
        check_schema(contract, schema["additionalProperties"], place + "/additionalProperties");
    if (!schema.contains("properties")) return;
    for (const auto& [name, property] : schema["properties"].items())
        check_schema(contract, property, place + "/" + name);
}

}  // namespace kiln
