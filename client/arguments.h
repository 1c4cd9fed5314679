// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <CLI/CLI.hpp>
#include <functional>
#include <limits>
#include <string>
#include <type_traits>

#include "client/commands.h"

/// What the command line's own files share; nobody else includes this.
namespace kiln::client {

inline constexpr const char* kExitCodes =
    "Exit status: 0 done, 1 failed, 2 wrong arguments or files, 3 invalid job, 4 server "
    "unreachable,\n"
    "5 timed out, 6 difference found or bound not met, 130 interrupted.";

/// What the arguments ask for. `run` is set by the subcommand that was named.
struct Arguments {
    BakeOptions bake;
    StudyOptions study;
    AdviseOptions advise;
    SceneOptions scene;
    SliceOptions slices;
    ViewOptions view;
    FitOptions fit;
    ServerOptions server;
    std::vector<std::string> files;
    std::string file, other_file, id, state, progress = "auto";
    double max_error = 0;
    std::size_t count_max = 20;
    bool json = false;
    std::function<Exit()> run;
};

/// CLI::Range lets NaN through, which lies neither below nor above anything.
template <typename Number>
CLI::Validator number_within(Number least, Number most = std::numeric_limits<Number>::max()) {
    const auto text = [](Number number) { return format_number(static_cast<double>(number)); };
    const std::string allowed =
        std::string(std::is_integral_v<Number> ? "a whole number" : "a finite number") +
        (most == std::numeric_limits<Number>::max() ? " of at least " + text(least)
                                                    : " from " + text(least) + " to " + text(most));
    return CLI::Validator(
        [=](std::string& input) -> std::string {
            Number number{};
            const bool within =
                CLI::detail::lexical_cast(input, number) && number >= least && number <= most;
            return within ? "" : input + " is not " + allowed;
        },
        "");
}

void add_json(CLI::App& command, Arguments& arguments);
void add_server(CLI::App& command, std::string& server);

/// The commands that bake: bake, plan, advise and the studies.
void add_baking(CLI::App& app, Arguments& arguments);

}  // namespace kiln::client
