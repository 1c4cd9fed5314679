// SPDX-License-Identifier: Apache-2.0
#include "server/settings/settings.h"

#include <algorithm>
#include <cctype>
#include <charconv>

#include "server/base/error.h"

namespace kiln {

namespace {

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
                                       "\" is not HOST:PORT; give for example " + kDefaultAddress +
                                       ", [::1]:8117, or port 0 for a free one");
    endpoint.port = port;
    return endpoint;
}

}  // namespace kiln
