// SPDX-License-Identifier: Apache-2.0
#include "client/arguments.h"

#include <map>

#include "server/spec/words.h"

namespace kiln::client {

namespace {

ProgressMode progress_mode(const std::string& word) {
    static const std::map<std::string, ProgressMode> modes{{"auto", ProgressMode::automatic},
                                                           {"bar", ProgressMode::bar},
                                                           {"plain", ProgressMode::plain},
                                                           {"json", ProgressMode::json},
                                                           {"none", ProgressMode::none}};
    return modes.at(word);
}

void add_watch(CLI::App& command, WatchOptions& options, Arguments& arguments) {
    command
        .add_option("--timeout", options.timeout_s,
                    "give up, and cancel, after this long; 0 = never")
        ->type_name("SECONDS")
        ->check(number_within(0.0, 1e6));
    command
        .add_option("--progress", arguments.progress,
                    "on standard error: auto, bar, plain, json, none")
        ->type_name("HOW")
        ->check(CLI::IsMember({"auto", "bar", "plain", "json", "none"}).description(""));
}

void add_run(CLI::App& command, RunOptions& options, Arguments& arguments) {
    add_server(command, options.server);
    command.add_flag("--local", options.local, "bake in this process, ask no server");
    add_watch(command, options, arguments);
}

void add_settings(CLI::App& command, std::vector<std::string>& settings,
                  const std::string& examples) {
    command.add_option("--set", settings, "change the job: " + examples + ", …")
        ->type_name("FIELD=VALUE")
        ->allow_extra_args(false);
}

/// What the options above say together.
void settle_run(RunOptions& options, const Arguments& arguments) {
    if (options.local && !options.server.empty())
        throw Failure(Exit::usage, "usage", "--local and --server exclude each other");
    options.progress = progress_mode(arguments.progress);
}

/// A scene takes the options of a job, and these.
void add_scene_options(CLI::App& command, Arguments& arguments) {
    command
        .add_option("--scene", arguments.scene.scene,
                    "in place of a job: bake what this glTF scene or list of materials needs")
        ->type_name("SCENE");
    command
        .add_option("--max-error", arguments.scene.max_error,
                    "of a scene: refine until every albedo is within X of the full set's")
        ->type_name("X")
        ->check(number_within(0.0, 1.0));
    command.add_flag(
        "--no-proof", [&arguments](std::int64_t) { arguments.scene.prove = false; },
        "of a scene: do not compare with the full set");
}

/// Exactly one of a job and a scene; what both take is read as the job's.
void take_scene(Arguments& arguments) {
    SceneOptions& scene = arguments.scene;
    const BakeOptions& bake = arguments.bake;
    if (scene.scene.empty() == bake.job.empty())
        throw Failure(Exit::usage, "usage", "bake takes either a job or --scene");
    if (scene.scene.empty() && (scene.max_error || !scene.prove))
        throw Failure(Exit::usage, "usage", "--max-error and --no-proof go with --scene");
    if (!scene.scene.empty() && !bake.sidecar.empty())
        throw Failure(Exit::usage, "usage",
                      "--sidecar goes with a job; a scene's atlas has its own in the folder");
    if (scene.max_error && !scene.prove)
        throw Failure(Exit::usage, "usage", "--max-error and --no-proof exclude each other");
}

Exit bake_any(Arguments& arguments) {
    if (arguments.scene.scene.empty()) return bake(arguments.bake);
    const BakeOptions& options = arguments.bake;
    SceneOptions& scene = arguments.scene;
    scene.settings = options.settings;
    scene.output = options.output;
    scene.report = options.report;
    scene.measurements = options.measurements;
    static_cast<RunOptions&>(scene) = options;
    return bake_scene(scene);
}

void add_plan(CLI::App& app, Arguments& arguments) {
    CLI::App& command =
        *app.add_subcommand("plan", "Say which tables a scene needs, and which it does not");
    command.add_option("scene", arguments.scene.scene, ".gltf, .glb or a list of materials")
        ->required()
        ->type_name("SCENE");
    command
        .add_option("--set", arguments.scene.settings,
                    "resolution=128, sample_count=4096, multiscatter=turquin, diffuse=burley, "
                    "pixel=float, scene=NAME, variant=all, …")
        ->type_name("OPTION=VALUE")
        ->allow_extra_args(false);
    add_json(command, arguments);
    command.footer(
        "Examples:\n"
        "  kiln plan sofa.glb\n"
        "  kiln bake --scene sofa.glb -o tables/ --max-error 0.01\n"
        "\nNothing but the file itself is read: pack images into a .glb to have them looked into.");
    command.callback([&arguments] {
        arguments.run = [&] {
            arguments.scene.json = arguments.json;
            return plan(arguments.scene);
        };
    });
}

void add_bake(CLI::App& app, Arguments& arguments) {
    CLI::App& command =
        *app.add_subcommand("bake", "Bake a job into an EXR or PNG, or a scene into a folder");
    BakeOptions& options = arguments.bake;
    command.add_option("job", options.job, "job document, - for standard input")
        ->type_name("JOB.json");
    command
        .add_option("-o,--output", options.output,
                    ".exr or .png, - for standard output; chooses the format unless the job does. "
                    "Of a scene: a folder")
        ->required()
        ->type_name("FILE");
    add_scene_options(command, arguments);
    add_settings(command, options.settings, "seed=7, output.pixel=float");
    command.add_option("--report", options.report, "write the report (error, run time, device)")
        ->type_name("FILE");
    command
        .add_option("--measurement", options.measurements,
                    "a measured file that the job or scene names by its sha256; may be repeated")
        ->type_name("FILE")
        ->allow_extra_args(false);
    command
        .add_option("--sidecar", options.sidecar,
                    "of slices and atlases: what a shader has to know; else OUTPUT.sidecar.json")
        ->type_name("FILE");
    add_run(command, options, arguments);
    add_json(command, arguments);
    command.footer(
        "Examples:\n"
        "  kiln bake examples/split_sum.json -o dfg.exr\n"
        "  kiln bake examples/split_sum_png.json --set resolution=[64,64] --set device=native -o "
        "dfg.png\n"
        "  kiln bake - -o - --report dfg.json < job.json > dfg.exr\n"
        "  kiln bake --scene sofa.glb -o tables/ --max-error 0.01\n"
        "  kiln bake examples/slices_lacquer.json -o lacquer.exr\n"
        "\nWith no server named and none at the usual place, bakes in this process and says so.\n" +
        std::string(kExitCodes));
    command.callback([&arguments, &options] {
        settle_run(options, arguments);
        take_scene(arguments);
        arguments.run = [&] { return bake_any(arguments); };
    });
}

struct StudyCommand {
    Kind kind;
    const char* summary;
    const char* of;  ///< what its document is, "" where it takes none
    const char* footer;
};

constexpr StudyCommand kStudies[] = {
    {Kind::convergence, "Measure error against run time and samples", "job document",
     "Examples:\n"
     "  kiln convergence examples/split_sum.json -o convergence\n"
     "  kiln convergence examples/split_sum.json --set sample_count=16384 --local -o convergence\n"
     "\nGoes through every sampler, importance and backend from 32 samples to the job's, three "
     "times,\nbeside quadrature and, where it is installed, cmgen. Writes convergence.png, .svg, "
     ".csv and\n.json into DIR.\n"},
    {Kind::furnace, "Judge a material: white furnace, positivity, reciprocity", "job document",
     "Examples:\n"
     "  kiln furnace examples/split_sum.json\n"
     "  kiln furnace material.json --set coupling=kelemen -o furnace\n"
     "\nTakes the material of any job document. Writes furnace.png, .svg, .csv and .json into "
     "DIR.\n"},
    {Kind::stability, "Hold every model on extreme inputs against its correct value", "",
     "Examples:\n"
     "  kiln stability -o stability\n"
     "  kiln stability --set device=native --json\n"
     "\nWrites stability.png, .svg, .csv and .json into DIR.\n"},
};

void add_study(CLI::App& app, Arguments& arguments, const StudyCommand& study_command) {
    const std::string name(to_word(study_command.kind));
    CLI::App& command = *app.add_subcommand(name, study_command.summary);
    StudyOptions& options = arguments.study;
    if (*study_command.of != '\0') {
        command
            .add_option("job", options.job,
                        std::string(study_command.of) + ", - for standard input")
            ->required()
            ->type_name("JOB.json");
    }
    add_settings(command, options.settings, "seed=7, device=native");
    command.add_option("-o,--output", options.folder, "folder for the pictures and the numbers")
        ->type_name("DIR");
    add_run(command, options, arguments);
    add_json(command, arguments);
    command.footer(
        study_command.footer +
        std::string("A verdict: yes; known, it does not hold and need not; no, exit status 6.\n") +
        kExitCodes);
    command.callback([&arguments, &options, kind = study_command.kind] {
        settle_run(options, arguments);
        options.kind = kind;
        arguments.run = [&] { return study(options); };
    });
}

void add_advise(CLI::App& app, Arguments& arguments) {
    CLI::App& command =
        *app.add_subcommand("advise", "Find the smallest table whose error stays within a bound");
    AdviseOptions& options = arguments.advise;
    command.add_option("job", options.job, "job document, - for standard input")
        ->required()
        ->type_name("JOB.json");
    command
        .add_option("--max-error", options.max_error,
                    "most that a lookup may be off: sampling, pixel type and bilinear lookup")
        ->required()
        ->type_name("X")
        ->check(number_within(1e-6, 1.0));
    add_settings(command, options.settings, "output.format=png, layout=unity");
    add_watch(command, options, arguments);
    add_json(command, arguments);
    command.footer(
        "Example:\n  kiln advise examples/split_sum.json --max-error 1e-3\n"
        "\nTries square tables of 18 sizes, axis mappings and grids (those of a program's layout "
        "stay as\nthey are) and the pixel types of the job's format against exact values, for NoV "
        "and alpha from\n1e-4 on; narrows the three smallest; prints the smallest and the job of "
        "the first. Exit status 6\nwhere none up to 4096 texels a side is within X.\n" +
        std::string(kExitCodes));
    command.callback([&arguments, &options] {
        options.progress = progress_mode(arguments.progress);
        arguments.run = [&options] { return advise(options); };
    });
}

}  // namespace

void add_baking(CLI::App& app, Arguments& arguments) {
    add_bake(app, arguments);
    add_plan(app, arguments);
    for (const StudyCommand& command : kStudies) add_study(app, arguments, command);
    add_advise(app, arguments);
}

}  // namespace kiln::client
