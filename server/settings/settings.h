// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "server/base/default_address.h"

namespace kiln {

/// Largest value of the setting `workers`.
inline constexpr std::int64_t kWorkersMax = 64;

/// Largest value of the setting `upload_mib`: what the readers of measurements take.
inline constexpr std::int64_t kUploadMibMost = 72;

/// What an operator may set. The values here are the defaults; names, ranges, units and help are in
/// settings_table(), which flags, environment, --help and /v1/capabilities are made from.
struct Settings {
    std::string listen = kDefaultAddress;
    std::string data_dir;  ///< "" stands for the state directory of the user, see resolve()
    std::string device = "auto";
    std::int64_t workers = 1;
    std::int64_t threads = 0;
    std::int64_t queue_max = 64;
    std::int64_t cache_mib = 10240;
    std::int64_t hot_cache_mib = 64;
    std::int64_t downloads_mib = 512;
    std::int64_t upload_mib = 64;
    std::int64_t measurements_mib = 4096;
    std::int64_t connections_max = 256;
    std::int64_t header_timeout_s = 3;
    std::int64_t idle_timeout_s = 5;
    std::int64_t body_timeout_s = 20;
    std::int64_t send_timeout_s = 10;
    std::int64_t lease_s = 10;
    std::int64_t attempts_max = 3;
    std::int64_t stall_s = 10;
    std::int64_t silence_s = 10;
    std::int64_t breaker_deaths = 3;
    std::int64_t breaker_s = 60;
    std::int64_t drain_s = 10;

    // Only a supervisor gives these to the workers that it starts.
    std::string worker_name;
    std::string opencl_off_reason;
    std::int64_t opencl_off_s = 0;
    std::int64_t doorbell_fd = -1;
};

/// Who reads a setting.
enum class Reader { serve, worker, both, supervised };

struct Setting {
    std::string_view name;  ///< in snake case: --queue-max and KILN_QUEUE_MAX come from "queue_max"
    std::variant<std::int64_t Settings::*, std::string Settings::*> field;
    std::int64_t min = 0, max = 0;               ///< of a number
    std::vector<std::string_view> choices = {};  ///< of a text; empty: any
    std::string_view unit = "";
    Reader reader = Reader::serve;
    std::string_view help = "";
};

const std::vector<Setting>& settings_table();

using Environment = std::function<std::optional<std::string>(const std::string&)>;

/// Flags (`--name value` or `--name=value`) over environment over defaults. Throws
/// Error("bad_setting") naming the flag or variable, what was wrong and what is allowed.
Settings read_settings(const std::vector<std::string>& arguments, Reader reader,
                       const Environment& environment);

/// The value of a setting as text, as a flag would take it.
std::string value_text(const Settings& settings, const Setting& setting);

/// One paragraph a setting, for --help.
std::string settings_help(Reader reader);

/// $XDG_STATE_HOME/kiln, or ~/.local/state/kiln. Throws Error("bad_setting") when neither is known.
std::string default_data_dir(const Environment& environment);

/// "127.0.0.1:8117" or "[::1]:8117".
struct Endpoint {
    std::string host;
    int port = 0;
};
Endpoint parse_endpoint(const std::string& text);

}  // namespace kiln
