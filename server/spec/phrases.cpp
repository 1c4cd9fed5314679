// SPDX-License-Identifier: Apache-2.0
#include "server/spec/phrases.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <numeric>

#include "server/spec/json_text.h"

namespace kiln {
namespace {

using Json = nlohmann::json;

/// Levenshtein's distance, for suggestions; both words are short.
std::size_t edit_distance(std::string_view a, std::string_view b) {
    std::vector<std::size_t> row(b.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t{0});
    for (std::size_t i = 1; i <= a.size(); ++i) {
        std::size_t diagonal = row[0];
        row[0] = i;
        for (std::size_t j = 1; j <= b.size(); ++j) {
            const std::size_t above = row[j];
            row[j] =
                std::min({above + 1, row[j - 1] + 1, diagonal + (a[i - 1] == b[j - 1] ? 0 : 1)});
            diagonal = above;
        }
    }
    return row[b.size()];
}

}  // namespace

std::vector<std::string> type_names(const nlohmann::json& type) {
    if (type.is_string()) return {type.get<std::string>()};
    return type.get<std::vector<std::string>>();
}

std::string type_phrase(const nlohmann::json& type) {
    std::string phrase;
    for (const std::string& name : type_names(type)) {
        if (!phrase.empty()) phrase += " or ";
        if (name == "null")
            phrase += "null";
        else
            phrase += (name.find_first_of("aeiou") == 0 ? "an " : "a ") + name;
    }
    return phrase;
}

std::string found(const nlohmann::json& value) {
    switch (value.type()) {
        case Json::value_t::string:
            return in_quotes(value.get_ref<const std::string&>());
        case Json::value_t::array:
            return "an array of " + std::to_string(value.size());
        case Json::value_t::object:
            return "an object";
        default:
            return value.dump();
    }
}

std::string list_of(const nlohmann::json& values) {
    std::string text;
    for (const nlohmann::json& value : values) text += (text.empty() ? "" : ", ") + found(value);
    return text;
}

std::string suggestion(std::string_view word, const std::vector<std::string>& known) {
    constexpr std::size_t kLongestWord = 64;  // bounds the work that one wrong name costs
    if (word.size() > kLongestWord) return "";
    // A third of the letters may differ, of short words two: neighbours that changed places.
    std::size_t nearest = word.size() < 3 ? 1 : std::max<std::size_t>(2, word.size() / 3);
    const std::string* best = nullptr;
    // "samples" means sample_count, however near the letters of sampler are.
    const std::string stem(word.ends_with('s') ? word.substr(0, word.size() - 1) : word);
    for (const std::string& candidate : known) {
        const bool begins = stem.size() > 2 && candidate.starts_with(stem + "_");
        const std::size_t distance = begins ? 0 : edit_distance(word, candidate);
        if (distance > nearest || (best && distance == nearest)) continue;
        nearest = distance;
        best = &candidate;
    }
    return best ? "; did you mean " + in_quotes(*best) + "?" : "";
}

}  // namespace kiln
