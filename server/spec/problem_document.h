// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "server/spec/spec.h"

namespace kiln {

/// application/problem+json text (RFC 9457) of the contract's schema Problem. Bytes that are not
/// UTF-8 come out as U+FFFD.
std::string problem_document(std::string_view code, int status, std::string_view title,
                             std::string_view detail, const std::vector<Problem>& problems = {});

}  // namespace kiln
