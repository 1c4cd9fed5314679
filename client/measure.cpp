// SPDX-License-Identifier: Apache-2.0
// `measure`: what looks at measured reflectance.
#include <cstdio>

#include "client/commands.h"
#include "client/files.h"
#include "client/terminal.h"
#include "server/measured/bounds.h"
#include "server/measured/survey.h"

namespace kiln::client {

namespace {

using namespace measured;

void print(const std::string& line) { std::printf("%s\n", printable(line).c_str()); }

std::string percent(double share) { return format_number(100 * share) + " %"; }

/// A table of incidences; of many, the first azimuth of each theta_in.
void print_incidences(const ComponentSurvey& part) {
    constexpr std::size_t kChannelsShown = 4;
    std::vector<std::vector<std::string>> rows{{"theta_in", "phi_in", "points", "measured"}};
    const std::size_t channels = std::min(part.channels.size(), kChannelsShown);
    for (std::size_t c = 0; c < channels; ++c) rows[0].push_back("albedo " + part.channels[c]);
    const IncidenceSurvey* last = nullptr;
    for (const IncidenceSurvey& one : part.incidences) {
        if (last && last->theta_i == one.theta_i) continue;
        last = &one;
        rows.push_back({format_number(one.theta_i), format_number(one.phi_i),
                        std::to_string(one.points), percent(one.coverage)});
        for (std::size_t c = 0; c < channels; ++c)
            rows.back().push_back(one.coverage > 0 ? format_number(one.albedo[c]) : "-");
    }
    for (const std::string& line : columns(rows)) print("  " + line);
}

void print_component(const ComponentSurvey& part) {
    print("");
    print(part.name + ": " + std::to_string(part.points) + " points, " +
          std::to_string(part.usable) + " usable (" + std::to_string(part.mirrored) +
          " mirrored), " + std::to_string(part.not_measured) + " not measured, " +
          std::to_string(part.below_horizon) + " below the horizon, " +
          std::to_string(part.rejected) + " rejected");
    print("  values " + format_number(part.value_min) + " to " + format_number(part.value_max) +
          " 1/sr, theta_out to " + format_number(part.theta_out_max) + " degrees");
    if (part.reciprocity.pairs > 0)
        print("  f(i,o) and f(o,i) differ by " + percent(part.reciprocity.median) + " (median), " +
              percent(part.reciprocity.p95) + " (95th percentile) in " +
              std::to_string(part.reciprocity.pairs) + " pairs");
    print_incidences(part);
}

}  // namespace

Exit measure_info(const std::string& path, bool json) {
    const std::string bytes = read_input(path, kFileBytesMax);
    Reading reading;
    try {
        reading = read_measurement(bytes);
    } catch (const Error& error) {
        throw Failure(Exit::usage, error.code(), path + ": " + error.what());
    }
    std::vector<ComponentSurvey> parts;
    for (const Component& component : reading.components) parts.push_back(survey(component));
    const Understood& account = reading.understood;
    if (json) {
        std::printf("%s\n", account_json(account, parts).c_str());
        return Exit::done;
    }
    print(path + "  " + account.format + (account.title.empty() ? "" : "  " + account.title));
    print("");
    for (const Finding& finding : account.findings)
        print(finding.what + ": " + finding.value + " (" + finding.evidence + ")");
    for (const LeftOut& left : account.left_out) print("left out: " + left.what + ": " + left.why);
    for (const std::string& warning : account.warnings) print("warning: " + warning);
    for (const ComponentSurvey& part : parts) print_component(part);
    print("");
    print("Albedo is the integral of f cos(theta_out) over the measured part of the hemisphere.");
    return Exit::done;
}

}  // namespace kiln::client
