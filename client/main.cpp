// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <clocale>
#include <csignal>
#include <cstdlib>
#include <new>

#include "client/arguments.h"
#include "client/json.h"
#include "server/base/version.h"
#include "server/scene/scene.h"
#include "server/spec/phrases.h"

namespace kiln::client {

void add_json(CLI::App& command, Arguments& arguments) {
    command.add_flag("--json", arguments.json, "JSON on standard output, errors included");
}

void add_server(CLI::App& command, std::string& server) {
    command
        .add_option("--server", server, "server's URL; also KILN_SERVER; else " + kDefaultServer)
        ->type_name("URL");
}

namespace {

void add_files(CLI::App& app, Arguments& arguments) {
    CLI::App& info_command = *app.add_subcommand("info", "Show what an EXR or PNG holds");
    info_command.add_option("file", arguments.file, "- for standard input")
        ->required()
        ->type_name("FILE");
    add_json(info_command, arguments);
    info_command.footer("Example:\n  kiln info dfg.exr");
    info_command.callback(
        [&arguments] { arguments.run = [&] { return info(arguments.file, arguments.json); }; });

    CLI::App& diff_command = *app.add_subcommand("diff", "Compare two tables texel by texel");
    diff_command.add_option("a", arguments.file, "an EXR or PNG, - for standard input")
        ->required()
        ->type_name("A");
    diff_command.add_option("b", arguments.other_file, "another EXR or PNG")
        ->required()
        ->type_name("B");
    diff_command
        .add_option("--max-error", arguments.max_error,
                    "largest difference that still passes; else 0")
        ->type_name("X")
        ->check(number_within(0.0));
    add_json(diff_command, arguments);
    diff_command.footer(
        "Example:\n  kiln diff before.exr after.exr --max-error 1e-4\n"
        "\nExit status 6 if any texel differs by more than X, or is NaN in either, or if sizes or "
        "channel\n"
        "names differ; 2 if a file cannot be read. Formats and pixel types may differ.");
    diff_command.callback([&arguments] {
        arguments.run = [&] {
            return diff(arguments.file, arguments.other_file, arguments.max_error, arguments.json);
        };
    });

    CLI::App& devices_command =
        *app.add_subcommand("devices", "List what this machine can bake with");
    add_json(devices_command, arguments);
    devices_command.callback(
        [&arguments] { arguments.run = [&] { return devices(arguments.json); }; });
}

void add_jobs(CLI::App& app, Arguments& arguments) {
    CLI::App& ls = *app.add_subcommand("ls", "List a server's jobs, newest first");
    add_server(ls, arguments.server.server);
    ls.add_option("--state", arguments.state, "queued, running, done, failed or cancelled")
        ->type_name("STATE")
        ->check(
            CLI::IsMember({"queued", "running", "done", "failed", "cancelled"}).description(""));
    ls.add_option("--limit", arguments.count_max, "at most this many; else 20")
        ->type_name("N")
        ->check(number_within(1, 10000));
    add_json(ls, arguments);
    ls.footer("Example:\n  kiln ls --state running");
    ls.callback([&arguments] {
        arguments.run = [&] {
            return list_jobs(arguments.server, arguments.state, arguments.count_max);
        };
    });

    CLI::App& cancel_command = *app.add_subcommand("cancel", "Cancel a server's job");
    cancel_command.add_option("id", arguments.id, "job id, or its first 8 digits or more")
        ->required()
        ->type_name("ID");
    add_server(cancel_command, arguments.server.server);
    add_json(cancel_command, arguments);
    cancel_command.footer("Example:\n  kiln cancel 3f9ac51e");
    cancel_command.callback(
        [&arguments] { arguments.run = [&] { return cancel(arguments.server, arguments.id); }; });
}

void add_phi_in(CLI::App& command, std::optional<double>& phi_in) {
    command
        .add_option("--phi-in", phi_in,
                    "azimuth of the light on a material that turns; else the mean of all")
        ->type_name("DEGREES")
        ->check(number_within(0.0, 360.0));
}

void add_slices(CLI::App& measure, Arguments& arguments) {
    CLI::App& command = *measure.add_subcommand(
        "slices", "Bake measured files into slices about the mirror direction, or an atlas");
    SliceOptions& options = arguments.slices;
    command.add_option("files", options.files, "a material each")->required()->type_name("FILE");
    command.add_option("-o,--output", options.output, ".exr (half, with origins) or .png")
        ->required()
        ->type_name("FILE");
    command.add_option("--sidecar", options.sidecar, "what a shader has to know, as JSON")
        ->type_name("FILE");
    command
        .add_option("--theta-in", options.theta_in, "incidences of the slices; else 0 to 60 by 5")
        ->delimiter(',')
        ->type_name("DEGREES,…");
    add_phi_in(command, options.phi_in);
    command.add_option("--width", options.width, "texels of a slice; else 361")
        ->type_name("N")
        ->check(number_within(2, 4096));
    command.add_option("--height", options.height, "texels of a slice; else 181")
        ->type_name("N")
        ->check(number_within(2, 4096));
    command.add_option("--gutter", options.gutter, "texels around each cell; else 0")
        ->type_name("N")
        ->check(number_within(0, 64));
    command
        .add_option("--extrapolation-p", options.extrapolation.p,
                    "what is left of f at the horizon beyond the measured angles; else 1: clamped")
        ->type_name("P")
        ->check(number_within(0.0, 100.0));
    command
        .add_option("--extrapolation-l", options.extrapolation.l,
                    "of the curve down to it, 0 to 1; else 0.3")
        ->type_name("L")
        ->check(number_within(0.0, 1.0));
    command.add_flag_callback(
        "--clamp-theta-in",
        [&options] { options.extrapolation.theta_in = measured::ThetaInBeyond::clamp; },
        "beyond the last incidence repeat its lobe, instead of using reciprocity");
    add_json(command, arguments);
    command.footer(
        "Example:\n  kiln measure slices a.bsdf b.bsdf -o atlas.exr --sidecar atlas.json "
        "--gutter 1");
    command.callback([&arguments, &options] {
        arguments.run = [&arguments, &options] {
            options.json = arguments.json;
            return measure_slices(options);
        };
    });
}

void add_upload(CLI::App& measure, Arguments& arguments) {
    CLI::App& command = *measure.add_subcommand(
        "upload", "Give measured files to a server and print their ids for jobs");
    command.add_option("files", arguments.files, "measured files")->required()->type_name("FILE");
    add_server(command, arguments.server.server);
    add_json(command, arguments);
    command.footer("Example:\n  kiln measure upload paint.bsdf felt.bsdf");
    command.callback([&arguments] {
        arguments.run = [&] { return measure_upload(arguments.server, arguments.files); };
    });
}

void add_view(CLI::App& measure, Arguments& arguments) {
    CLI::App& command = *measure.add_subcommand(
        "view", "Draw a measured file's reflection lobe, or a sphere of its material");
    ViewOptions& options = arguments.view;
    command.add_option("file", options.file, "a measured file, - for standard input")
        ->required()
        ->type_name("FILE");
    command.add_option("-o,--output", options.output, "a .png")->required()->type_name("FILE");
    command.add_option("--theta-in", options.theta_in, "of the lobe's light; else 30")
        ->type_name("DEGREES")
        ->check(number_within(0.0, 89.0));
    add_phi_in(command, options.phi_in);
    command.add_option("--size", options.size, "pixels along the picture; else 640")
        ->type_name("N")
        ->check(number_within(64, 2048));
    command.add_flag("--sphere", options.sphere,
                     "a lit sphere in place of the lobe; goes without --theta-in");
    command.footer("Example:\n  kiln measure view paint.bsdf --theta-in 30 -o lobe.png");
    command.callback(
        [&arguments, &options] { arguments.run = [&options] { return measure_view(options); }; });
}

void add_measure(CLI::App& app, Arguments& arguments) {
    CLI::App& measure = *app.add_subcommand("measure", "Measured reflectance");
    measure.require_subcommand(1);
    CLI::App& info_command = *measure.add_subcommand("info", "Show what a measured file says");
    info_command.add_option("file", arguments.file, "- for standard input")
        ->required()
        ->type_name("FILE");
    add_json(info_command, arguments);
    info_command.footer("Example:\n  kiln measure info paint.bsdf");
    info_command.callback([&arguments] {
        arguments.run = [&] { return measure_info(arguments.file, arguments.json); };
    });
    CLI::App& fit_command =
        *measure.add_subcommand("fit", "Fit analytic models to a measured file, and say the error");
    fit_command.add_option("file", arguments.fit.file, "- for standard input")
        ->required()
        ->type_name("FILE");
    fit_command
        .add_option("--error-map", arguments.fit.error_map,
                    ".png or .exr: where each model misses, about the mirror direction")
        ->type_name("FILE");
    add_phi_in(fit_command, arguments.fit.phi_in);
    add_json(fit_command, arguments);
    fit_command.footer("Example:\n  kiln measure fit paint.bsdf --error-map misses.png");
    fit_command.callback([&arguments] {
        arguments.run = [&] {
            arguments.fit.json = arguments.json;
            return measure_fit(arguments.fit);
        };
    });
    add_slices(measure, arguments);
    add_upload(measure, arguments);
    add_view(measure, arguments);
}

/// The library would say that a command is missing, and of a wrong one no word.
void expect_command(const CLI::App& app, int argc, char** argv) {
    if (argc < 2) return;
    const std::string word = argv[1];
    const bool option = word.starts_with('-');
    std::vector<std::string> known;
    std::string all;
    if (option)
        known = {"-h", "--help", "--version"};
    else
        for (const CLI::App* command : app.get_subcommands({}))
            known.push_back(command->get_name());
    if (std::find(known.begin(), known.end(), word) != known.end()) return;
    for (const std::string& one : known) all += (all.empty() ? "" : ", ") + one;
    const std::string near = suggestion(word, known);
    throw Failure(Exit::usage, "usage",
                  "\"" + word + "\" is no " + (option ? "option before a command" : "command") +
                      (near.empty() ? "." : near) + " There are " + all);
}

/// Flags before environment before defaults.
void take_environment(Arguments& arguments) {
    const char* server = std::getenv("KILN_SERVER");
    if (server == nullptr) return;
    for (RunOptions* options :
         {static_cast<RunOptions*>(&arguments.bake), static_cast<RunOptions*>(&arguments.study)})
        if (options->server.empty() && !options->local) options->server = server;
    if (arguments.server.server.empty()) arguments.server.server = server;
}

Exit complain(const Arguments& arguments, Exit exit, const ProblemDocument& problem) {
    if (arguments.json) std::printf("%s\n", problem_json(problem).c_str());
    // The pointers and messages below say the same as the summary of them.
    const bool summed_up = problem.problems.empty() || problem.code == "measurement_missing";
    say("kiln: " + printable(summed_up                       ? problem.detail
                             : arguments.scene.scene.empty() ? "the job is not valid"
                                                             : "the scene is not valid"));
    for (const Problem& entry : problem.problems)
        say("  " + printable(entry.pointer.empty() ? "(document)" : entry.pointer) + ": " +
            printable(entry.message));
    return exit;
}

Exit run(Arguments& arguments) {
    const auto complain_of = [&](Exit exit, const Error& error,
                                 std::vector<Problem> problems = {}) {
        return complain(arguments, exit, {error.code(), error.what(), std::move(problems)});
    };
    try {
        return arguments.run();
    } catch (const Failure& failure) {
        return complain_of(failure.exit, failure, failure.problems);
    } catch (const InvalidJob& error) {
        return complain_of(Exit::invalid_job, error, error.problems);
    } catch (const InvalidScene& error) {
        return complain_of(Exit::invalid_job, error, error.problems);
    } catch (const Malformed& error) {
        return complain_of(Exit::invalid_job, error, error.problems);
    } catch (const Error& error) {
        return complain_of(Exit::failed, error);
    } catch (const std::bad_alloc&) {
        return complain(arguments, Exit::failed, {"out_of_memory", "out of memory", {}});
    } catch (const std::exception& error) {
        return complain(arguments, Exit::failed, {"internal", error.what(), {}});
    }
}

}  // namespace

int parse_and_run(int argc, char** argv) {
    std::setlocale(LC_CTYPE, "");   // whether the terminal shows UTF-8; numbers keep the C locale
    std::signal(SIGPIPE, SIG_IGN);  // a closed pipe is an error message, not a silent death
    Arguments arguments;
    CLI::App app("Kiln bakes BRDF lookup tables.", "kiln");
    app.set_version_flag("--version", std::string("kiln ") + kVersion);
    app.require_subcommand(1);
    app.failure_message([](const CLI::App* root, const CLI::Error& error) {
        const auto named = root->get_subcommands();
        const std::string command = named.empty() ? "" : " " + named.front()->get_name();
        return "kiln: " + printable(error.what()) + "\n  kiln" + command + " --help tells more\n";
    });
    app.footer(kExitCodes);  // of each command that has none of its own
    add_baking(app, arguments);
    add_files(app, arguments);
    add_jobs(app, arguments);
    add_measure(app, arguments);
    const auto more = [](const std::string& name) {
        return name + " COMMAND --help tells more of each.\n\n" + std::string(kExitCodes);
    };
    app.footer(more("kiln"));
    app.get_subcommand("measure")->footer(more("kiln measure"));
    try {
        expect_command(app, argc, argv);
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? 0 : static_cast<int>(Exit::usage);
    } catch (const Failure& failure) {
        return static_cast<int>(
            complain(arguments, failure.exit, {failure.code(), failure.what(), {}}));
    }
    arguments.bake.json = arguments.study.json = arguments.advise.json = arguments.server.json =
        arguments.json;
    take_environment(arguments);
    return static_cast<int>(run(arguments));
}

}  // namespace kiln::client

int main(int argc, char** argv) { return kiln::client::parse_and_run(argc, argv); }
