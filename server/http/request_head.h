// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <string>
#include <string_view>

#include "server/http/message.h"

namespace kiln {

/// Bounds of a request's head that no setting widens.
inline constexpr std::size_t kHeadBytesMax = 16 * 1024;
inline constexpr std::size_t kHeadLinesMax = 64;  ///< header fields, without the request line
inline constexpr std::size_t kPathBytesMax = 256;
inline constexpr std::size_t kTargetBytesMax = 2048;

struct RequestHead {
    HttpRequest request;  ///< without body
    std::uint64_t content_length = 0;
    bool expects_continue = false;
};

/// Reads a head that ends with an empty line, CRLF everywhere, more strictly than HTTP allows: what
/// two readers could understand differently is refused. Throws Error with a code of problems.h:
/// bad_request, bad_version, bad_query, uri_too_long, headers_too_large, length_required,
/// wrong_type, bad_expectation.
RequestHead parse_head(std::string_view text);

}  // namespace kiln
