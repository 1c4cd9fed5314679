// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <string>
#include <string_view>

#include "server/http/message.h"

namespace kiln {

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
