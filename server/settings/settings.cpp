// SPDX-License-Identifier: Apache-2.0
#include "server/settings/settings.h"

#include <algorithm>
#include <cctype>
#include <charconv>

#include "server/base/error.h"

namespace kiln {

namespace {

constexpr std::int64_t kMebibytesMax = std::int64_t{1} << 24;  // 16 TiB: bytes still fit 64 bits

std::string flag_of(const Setting& setting) {
    std::string flag = "--" + std::string(setting.name);
    std::replace(flag.begin(), flag.end(), '_', '-');
    return flag;
}

std::string variable_of(const Setting& setting) {
    std::string variable = "KILN_" + std::string(setting.name);
    std::transform(variable.begin(), variable.end(), variable.begin(),
                   [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
    return variable;
}

bool applies(const Setting& setting, Reader reader) {
    if (setting.reader == reader || setting.reader == Reader::both) return true;
    return setting.reader == Reader::supervised && reader == Reader::worker;
}

std::string allowed(const Setting& setting) {
    if (std::holds_alternative<std::int64_t Settings::*>(setting.field))
        return "an integer from " + std::to_string(setting.min) + " to " +
               std::to_string(setting.max);
    std::string words;
    for (const std::string_view choice : setting.choices)
        words += (words.empty() ? "" : ", ") + std::string(choice);
    return "one of " + words;
}

void assign(Settings& settings, const Setting& setting, const std::string& origin,
            const std::string& text) {
    const auto refuse = [&] {
        throw Error("bad_setting",
                    origin + ": \"" + text + "\" is not allowed; give " + allowed(setting));
    };
    if (const auto* number = std::get_if<std::int64_t Settings::*>(&setting.field)) {
        std::int64_t value = 0;
        const char* end = text.data() + text.size();
        const auto [stopped, error] = std::from_chars(text.data(), end, value);
        if (error != std::errc() || stopped != end) refuse();
        if (value < setting.min || value > setting.max) refuse();
        settings.*(*number) = value;
        return;
    }
    const auto& choices = setting.choices;
    if (!choices.empty() && std::find(choices.begin(), choices.end(), text) == choices.end())
        refuse();
    settings.*(std::get<std::string Settings::*>(setting.field)) = text;
}

const Setting& setting_of_flag(const std::string& flag, Reader reader) {
    for (const Setting& setting : settings_table())
        if (applies(setting, reader) && flag_of(setting) == flag) return setting;
    throw Error("bad_setting", "\"" + flag + "\" is not a known option; see --help");
}

}  // namespace

const std::vector<Setting>& settings_table() {
    using S = Settings;
    using R = Reader;
    static const std::vector<Setting> table = {
        {"listen", &S::listen, 0, 0, {}, "HOST:PORT", R::serve,
         "address to serve on; port 0 picks a free one"},
        {"data_dir", &S::data_dir, 0, 0, {}, "DIR", R::both,
         "jobs and results; default: kiln under the user's state directory"},
        {"device", &S::device, 0, 0, {"auto", "opencl", "native"}, "", R::both,
         "where jobs may run"},
        {"workers", &S::workers, 0, 64, {}, "processes", R::serve,
         "worker processes to start; 0 leaves the work to workers started elsewhere"},
        {"threads", &S::threads, 0, 1024, {}, "threads", R::both,
         "of the native backend of each worker; 0 is every core"},
        {"queue_max", &S::queue_max, 1, 100000, {}, "jobs", R::serve,
         "queued jobs before new ones get 429"},
        {"cache_mib", &S::cache_mib, 1, kMebibytesMax, {}, "MiB", R::both,
         "results kept on disk; the least recently used go first"},
        {"hot_cache_mib", &S::hot_cache_mib, 0, 65536, {}, "MiB", R::serve,
         "results kept in memory"},
        {"connections_max", &S::connections_max, 8, 4096, {}, "connections", R::serve,
         "served at once; half of them may wait for a job or listen to events"},
        {"header_timeout_s", &S::header_timeout_s, 1, 60, {}, "s", R::serve,
         "from the first byte of a request to the end of its header"},
        {"idle_timeout_s", &S::idle_timeout_s, 1, 600, {}, "s", R::serve,
         "an unused connection is kept"},
        {"body_timeout_s", &S::body_timeout_s, 1, 600, {}, "s", R::serve,
         "for the whole body of a request"},
        {"send_timeout_s", &S::send_timeout_s, 1, 600, {}, "s", R::serve,
         "a client may take no byte of an answer"},
        {"lease_s", &S::lease_s, 1, 3600, {}, "s", R::both,
         "a worker holds a job without renewing its claim"},
        {"attempts_max", &S::attempts_max, 1, 100, {}, "attempts", R::both,
         "at a job whose worker dies"},
        {"stall_s", &S::stall_s, 1, 3600, {}, "s", R::both,
         "without progress before a worker ends itself, as its device hangs"},
        {"silence_s", &S::silence_s, 2, 3600, {}, "s", R::serve,
         "without a sign of life before a worker is killed"},
        {"breaker_deaths", &S::breaker_deaths, 1, 1000, {}, "deaths", R::serve,
         "of workers within breaker_s that switch OpenCL off for as long"},
        {"breaker_s", &S::breaker_s, 1, 86400, {}, "s", R::serve, "see breaker_deaths"},
        {"drain_s", &S::drain_s, 0, 3600, {}, "s", R::serve,
         "running jobs get at shutdown before they go back to the queue"},
        {"worker_name", &S::worker_name, 0, 0, {}, "NAME", R::worker,
         "under which jobs are claimed; default: host and process id"},
        {"opencl_off_reason", &S::opencl_off_reason, 0, 0, {}, "TEXT", R::supervised,
         "why OpenCL is not touched"},
        {"opencl_off_s", &S::opencl_off_s, 0, 86400, {}, "s", R::supervised,
         "how long opencl_off_reason holds"},
        {"doorbell_fd", &S::doorbell_fd, -1, 1 << 20, {}, "", R::supervised,
         "socket to the supervisor"},
    };
    return table;
}

Settings read_settings(const std::vector<std::string>& arguments, Reader reader,
                       const Environment& environment) {
    Settings settings;
    for (const Setting& setting : settings_table())
        if (applies(setting, reader) && setting.reader != Reader::supervised)
            if (const auto text = environment(variable_of(setting)))
                assign(settings, setting, variable_of(setting), *text);
    for (std::size_t i = 0; i < arguments.size(); ++i) {
        const std::string& argument = arguments[i];
        const std::size_t equals = argument.find('=');
        const std::string flag = argument.substr(0, equals);
        const Setting& setting = setting_of_flag(flag, reader);
        if (equals != std::string::npos) {
            assign(settings, setting, flag, argument.substr(equals + 1));
        } else {
            if (++i == arguments.size())
                throw Error("bad_setting", flag + " needs a value; see --help");
            assign(settings, setting, flag, arguments[i]);
        }
    }
    if (settings.data_dir.empty()) settings.data_dir = default_data_dir(environment);
    return settings;
}

std::string value_text(const Settings& settings, const Setting& setting) {
    if (const auto* number = std::get_if<std::int64_t Settings::*>(&setting.field))
        return std::to_string(settings.*(*number));
    return settings.*(std::get<std::string Settings::*>(setting.field));
}

std::string settings_help(Reader reader) {
    const Settings defaults;
    std::string help;
    for (const Setting& setting : settings_table()) {
        if (!applies(setting, reader) || setting.reader == Reader::supervised) continue;
        help += "  " + flag_of(setting);
        if (!setting.choices.empty()) {
            help += ' ';
            for (const std::string_view choice : setting.choices)
                help += (choice == setting.choices.front() ? "" : "|") + std::string(choice);
        } else {
            help += ' ' + (setting.unit.empty() ? std::string("N") : std::string(setting.unit));
        }
        help += "  (" + variable_of(setting) + ")\n      " + std::string(setting.help);
        const std::string value = value_text(defaults, setting);
        if (!value.empty()) help += "; default " + value;
        if (std::holds_alternative<std::int64_t Settings::*>(setting.field))
            help += ", from " + std::to_string(setting.min) + " to " + std::to_string(setting.max);
        help += '\n';
    }
    return help;
}

std::string default_data_dir(const Environment& environment) {
    if (const auto state = environment("XDG_STATE_HOME"); state && !state->empty())
        return *state + "/kiln";
    if (const auto home = environment("HOME"); home && !home->empty())
        return *home + "/.local/state/kiln";
    throw Error("bad_setting", "give --data-dir: neither XDG_STATE_HOME nor HOME is set");
}

Endpoint parse_endpoint(const std::string& text) {
    const std::size_t colon = text.rfind(':');
    Endpoint endpoint;
    int port = -1;
    if (colon != std::string::npos) {
        const char* end = text.data() + text.size();
        const auto [stopped, error] = std::from_chars(text.data() + colon + 1, end, port);
        if (error != std::errc() || stopped != end) port = -1;
        endpoint.host = text.substr(0, colon);
    }
    std::string& host = endpoint.host;
    if (host.size() > 2 && host.front() == '[' && host.back() == ']')
        host = host.substr(1, host.size() - 2);
    else if (host.find(':') != std::string::npos)
        host.clear();
    if (host.empty() || port < 0 || port > 65535)
        throw Error("bad_setting", "--listen: \"" + text +
                                       "\" is not HOST:PORT; give for example 127.0.0.1:8117, "
                                       "[::1]:8117, or port 0 for a free one");
    endpoint.port = port;
    return endpoint;
}

}  // namespace kiln
