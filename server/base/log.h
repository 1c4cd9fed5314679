// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>

namespace kiln {

/// `text` as the inside of a JSON string: quotes, backslashes and every byte outside printable
/// ASCII are escaped, so that no text can end a log line or smuggle control bytes into a terminal.
std::string escaped(std::string_view text);

/// One JSON line {"time", "event", fields…} on standard error, written by a single write(2). Never
/// give it a request body or a key.
void log_line(std::string_view event,
              std::initializer_list<std::pair<std::string_view, std::string>> fields = {});

}  // namespace kiln
