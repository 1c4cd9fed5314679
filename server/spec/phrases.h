// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace kiln {

/// The entries of a schema's `type`, which is one name or a list of them.
std::vector<std::string> type_names(const nlohmann::json& type);

/// "an integer", "a number or null".
std::string type_phrase(const nlohmann::json& type);

/// What a document holds, for a message: bounded and escaped.
std::string found(const nlohmann::json& value);

/// The entries of an array, each as found().
std::string list_of(const nlohmann::json& values);

/// `; did you mean "…"?` when a known word is near, else "".
std::string suggestion(std::string_view word, const std::vector<std::string>& known);

}  // namespace kiln
