// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "server/http/message.h"
#include "server/spec/spec.h"

namespace kiln {

/// An answer that is not a success, by its stable code. The status and the title of every code
/// stand in one table; an unknown code is a 500.
HttpResponse problem(std::string_view code, std::string_view detail,
                     const std::vector<Problem>& problems = {});

/// The same for a failure that was thrown. What is no Error is logged under an id that the client
/// gets, and nothing else of it is told.
HttpResponse problem_of(const std::exception& failure);

/// Seconds after which a refused client may try again, as header.
void add_retry_after(HttpResponse& response, int seconds);

int status_of(std::string_view code);

}  // namespace kiln
