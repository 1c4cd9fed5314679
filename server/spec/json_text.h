// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace kiln {

struct TextLimits {
    std::int64_t bytes_max = 0;
    std::int64_t depth_max = 0;
    /// Values of any kind, which take far more memory than their text; a job's bytes bound them.
    std::int64_t values_max = INT64_MAX;
};

/// Untrusted RFC 8259 text to a value. Throws Malformed for text that is too large, too deep, not
/// UTF-8, starts with a byte order mark, holds a NUL byte or anything after the value, repeats a
/// name in an object, or has a number that a double cannot hold.
nlohmann::json parse_json(std::string_view text, const TextLimits& limits);

/// `text` for a message: in quotes, ASCII with escapes, at most some forty characters.
std::string in_quotes(std::string_view text);

/// RFC 6901: one reference token appended to a pointer.
std::string join_pointer(std::string_view pointer, std::string_view token);

}  // namespace kiln
