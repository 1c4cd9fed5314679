// SPDX-License-Identifier: Apache-2.0
#include "server/scene/walk.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "server/spec/json_text.h"
#include "server/spec/measurement_names.h"
#include "server/spec/phrases.h"

namespace kiln {

namespace {

using Json = nlohmann::json;

std::string plain(double value) { return Json(value).dump(); }

/// A whole number that a double holds exactly; glTF writers spell 1 as 1.0 too.
std::optional<std::size_t> whole(const Json& value) {
    if (!value.is_number()) return std::nullopt;
    if (value.is_number_unsigned()) return value.get<std::size_t>();
    const double number = value.get<double>();
    if (!(number >= 0) || number > 9007199254740992.0 || number != std::floor(number))
        return std::nullopt;
    return static_cast<std::size_t>(number);
}

}  // namespace

const Json* Place::member(const char* name) const {
    if (value_ == nullptr || !value_->is_object()) return nullptr;
    const auto found_member = value_->find(name);
    return found_member == value_->end() ? nullptr : &*found_member;
}

Place Place::at(const char* name, const Json* value) const {
    return {value, join_pointer(pointer_, name), *problems_};
}

void Place::wrong(const char* name, const Json& value, const std::string& allowed) const {
    problems_->add(join_pointer(pointer_, name), "is " + found(value) + "; must be " + allowed);
}

bool Place::has(const char* name) const { return member(name) != nullptr; }

Place Place::object(const char* name) const {
    const Json* value = member(name);
    if (value != nullptr && !value->is_object()) {
        wrong(name, *value, "an object");
        value = nullptr;
    }
    return at(name, value);
}

Place Place::extras(const char* name) const {
    const Json* value = member(name);
    return at(name, value != nullptr && value->is_object() ? value : nullptr);
}

Place Place::list(const char* name, std::size_t count_max) const {
    const Json* value = member(name);
    if (value != nullptr && !value->is_array()) {
        wrong(name, *value, "an array");
        value = nullptr;
    }
    if (value != nullptr && value->size() > count_max) {
        problems_->add(join_pointer(pointer_, name), "has " + std::to_string(value->size()) +
                                                         " entries; allowed: at most " +
                                                         std::to_string(count_max));
        value = nullptr;
    }
    return at(name, value);
}

Place Place::item(std::size_t index) const {
    const Json* value = value_ != nullptr && index < value_->size() ? &(*value_)[index] : nullptr;
    const std::string name = std::to_string(index);
    if (value != nullptr && !value->is_object()) {
        wrong(name.c_str(), *value, "an object");
        value = nullptr;
    }
    return at(name.c_str(), value);
}

std::size_t Place::size() const { return value_ == nullptr ? 0 : value_->size(); }

std::vector<std::string> Place::member_names() const {
    std::vector<std::string> names;
    if (value_ == nullptr || !value_->is_object()) return names;
    for (const auto& [name, value] : value_->items()) names.push_back(name);
    return names;
}

double Place::number(const char* name, double fallback, double lo, double hi) const {
    const Json* value = member(name);
    if (value == nullptr) return fallback;
    const double given = value->is_number() ? value->get<double>() : std::nan("");
    if (given >= lo && given <= hi) return given;
    wrong(name, *value,
          std::isinf(hi) ? "a number of at least " + plain(lo)
                         : "a number in " + plain(lo) + "…" + plain(hi));
    return fallback;
}

std::array<double, 3> Place::colour(const char* name, double fallback, double lo, double hi,
                                    std::size_t count) const {
    std::array<double, 3> result{fallback, fallback, fallback};
    const Json* value = member(name);
    if (value == nullptr) return result;
    bool good = value->is_array() && value->size() == count;
    for (std::size_t i = 0; good && i < count; ++i)
        good = (*value)[i].is_number() && (*value)[i].get<double>() >= lo &&
               (*value)[i].get<double>() <= hi;
    if (!good) {
        wrong(name, *value,
              std::to_string(count) + " numbers" +
                  (std::isinf(hi) ? " of at least " + plain(lo)
                                  : " in " + plain(lo) + "…" + plain(hi)));
        return result;
    }
    for (std::size_t i = 0; i < 3; ++i) result[i] = (*value)[i].get<double>();
    return result;
}

std::optional<std::size_t> Place::index(const char* name, std::size_t count,
                                        const char* what) const {
    const Json* value = member(name);
    if (value == nullptr) return std::nullopt;
    const auto given = whole(*value);
    if (given && *given < count) return given;
    wrong(name, *value, "the index of one of " + std::to_string(count) + " " + what);
    return std::nullopt;
}

std::optional<std::size_t> Place::bytes(const char* name) const {
    const Json* value = member(name);
    if (value == nullptr) return std::nullopt;
    const auto given = whole(*value);
    if (!given) wrong(name, *value, "a whole number of bytes");
    return given;
}

std::vector<std::size_t> Place::indices(const char* name, std::size_t count, const char* what,
                                        std::size_t count_max) const {
    std::vector<std::size_t> result;
    const Place entries = list(name, count_max);
    for (std::size_t i = 0; i < entries.size(); ++i) {
        const auto given = whole((*entries.value_)[i]);
        if (given && *given < count)
            result.push_back(*given);
        else
            entries.wrong(std::to_string(i).c_str(), (*entries.value_)[i],
                          "the index of one of " + std::to_string(count) + " " + what);
    }
    return result;
}

const std::string* Place::text_at(const char* name) const {
    const Json* value = member(name);
    if (value == nullptr) return nullptr;
    if (value->is_string()) return &value->get_ref<const std::string&>();
    wrong(name, *value, "a string");
    return nullptr;
}

std::string Place::text(const char* name, std::size_t characters_max) const {
    const std::string* given = text_at(name);
    if (given == nullptr) return "";
    if (given->size() <= characters_max) return *given;
    problems_->add(join_pointer(pointer_, name), "has " + std::to_string(given->size()) +
                                                     " bytes; allowed: at most " +
                                                     std::to_string(characters_max));
    return "";
}

std::string Place::measurement(const char* name) const {
    const std::string* given = text_at(name);
    if (given == nullptr) return "";
    if (!measurement_digest(*given).empty()) return *given;
    wrong(name, *member(name), kMeasurementAllowed);
    return "";
}

std::vector<std::string> Place::texts(const char* name, std::size_t count_max) const {
    std::vector<std::string> result;
    const Place entries = list(name, count_max);
    for (std::size_t i = 0; i < entries.size(); ++i) {
        const Json& value = (*entries.value_)[i];
        if (value.is_string())
            result.push_back(value.get<std::string>());
        else
            entries.wrong(std::to_string(i).c_str(), value, "a string");
    }
    return result;
}

}  // namespace kiln
