// SPDX-License-Identifier: Apache-2.0
#include "client/bakery.h"
#include "client/commands.h"
#include "client/files.h"
#include "client/interrupt.h"
#include "client/json.h"
#include "client/summary.h"
#include "server/spec/kinds.h"
#include "server/spec/settings.h"
#include "server/spec/words.h"

namespace kiln::client {

namespace {

/// Beside the image: atlas.exr has atlas.sidecar.json.
std::string sidecar_path(const BakeOptions& options) {
    if (!options.sidecar.empty() || options.output == "-") return options.sidecar;
    const std::string extension = extension_of(options.output);
    const std::size_t end = options.output.size() - (extension.empty() ? 0 : extension.size() + 1);
    return options.output.substr(0, end) + ".sidecar.json";
}

void check_arguments(const BakeOptions& options) {
    const std::string extension = extension_of(options.output);
    if (options.output != "-" && !extension.empty() && !from_word<ImageFormat>(extension))
        throw Failure(Exit::usage, "unknown_extension",
                      "-o " + options.output + ": Kiln writes .exr and .png");
    const bool json_on_stdout = options.json || options.report == "-";
    if (options.output == "-" && json_on_stdout)
        throw Failure(Exit::usage, "usage",
                      "-o - and the report both want standard output; give one of them a file");
    check_output(options.output);
    if (!options.report.empty() && options.report != "-") check_output(options.report);
}

JobSpec load_job(const BakeOptions& options, MeasurementFiles& files) {
    std::string text = read_job(options.job, options.settings);
    text = take_measurements(text, options.job, options.measurements, files);
    const std::string extension = extension_of(options.output);
    const bool named = options.output != "-" && !extension.empty();
    if (named && lacks_output_format(text)) {
        try {
            text = apply_settings(text, {"output.format=" + extension});
        } catch (const Malformed&) {  // repeated names and the like: parse_job says which
        }
    }
    JobSpec job = parse_job(text);
    if (named && to_word(job.format) != extension)
        throw InvalidJob(
            {{"/output/format", "the job asks for " + std::string(to_word(job.format)) +
                                    " and -o " + options.output + " for " + extension +
                                    "; name a file of that format or change the job"}});
    return job;
}

}  // namespace

Exit bake(const BakeOptions& options) {
    check_arguments(options);
    MeasurementFiles files;
    const JobSpec job = load_job(options, files);
    const std::string sidecar = is_measured(job.kind) ? sidecar_path(options) : "";
    if (!sidecar.empty()) check_output(sidecar);
    const Interrupt interrupt(options.timeout_s);
    const Stop stop(interrupt, options.timeout_s);
    const Baking result = run_job(options, job, stop, files);
    if (interrupt.requested()) stop.leave();

    write_output(options.output, result.image);
    if (!sidecar.empty()) write_output(sidecar, result.sidecar + "\n");
    if (!options.report.empty()) write_output(options.report, result.report + "\n");
    if (options.json && options.report != "-") write_output("-", result.report + "\n");
    if (const auto report = read_report(result.report))
        summarise(*report, job,
                  {.output = options.output,
                   .byte_count = result.image.size(),
                   .where = result.where,
                   .cached = result.cached,
                   .brief = options.json || options.progress == ProgressMode::json});
    return Exit::done;
}

}  // namespace kiln::client
