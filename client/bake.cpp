// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <chrono>
#include <cstdio>

#include "client/api.h"
#include "client/commands.h"
#include "client/files.h"
#include "client/interrupt.h"
#include "client/json.h"
#include "client/summary.h"
#include "server/compute/opencl_threads.h"
#include "server/spec/settings.h"
#include "server/spec/words.h"
#include "server/worker/bake.h"

namespace kiln::client {

namespace {

// Far above the contract's job_bytes_max, which parse_job judges; only there so that reading ends.
constexpr std::size_t kInputBytesMax = 16u << 20;
// A long-poll returns when the job ends; between, this is how often progress is seen.
constexpr double kPollWaitS = 0.5;
constexpr double kQuietWaitS = 20;  // where nobody watches

struct Result {
    std::string image;
    std::string report;  ///< JSON
    std::string where;   ///< the server, or "" for this process
    bool cached = false;
};

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

std::string apply_all(const std::string& text, const std::vector<std::string>& settings) {
    if (settings.empty()) return text;
    apply_settings(text, {});  // a document that cannot be read is the document's fault …
    try {
        return apply_settings(text, settings);
    } catch (const Malformed& error) {  // … and this one the argument's
        throw Failure(Exit::usage, "bad_setting", std::string("--set: ") + error.what());
    }
}

JobSpec load_job(const BakeOptions& options) {
    std::string text = apply_all(read_input(options.job, kInputBytesMax), options.settings);
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

/// Best effort: the reason for leaving is what the user hears, not that the server was gone too.
void abandon(const std::string& url, const std::string& id) {
    const auto give_up = std::chrono::steady_clock::now() + std::chrono::seconds(2);
    Api api(url, [give_up] { return std::chrono::steady_clock::now() > give_up; });
    try {
        api.cancel(id);
    } catch (const Error&) {
    }
}

JobStatus wait_for(Api& api, const JobSpec& job, const Stop& stop, ProgressMode mode) {
    ProgressView view(mode);
    const double wait_s = mode == ProgressMode::none ? kQuietWaitS : kPollWaitS;
    JobStatus status = api.submit(canonical(job), kPollWaitS);
    while (status.state == "queued" || status.state == "running") {
        view.update({status.state, status.progress, status.standard_error_max});
        if (stop.requested()) throw Cancelled();
        const auto asked = std::chrono::steady_clock::now();
        status = api.status(status.id, wait_s);
        // A server that is short of long-polls may answer at once; it is not to be asked in a tight
        // loop.
        while (status.state != "done" && !stop.requested() &&
               std::chrono::steady_clock::now() - asked < std::chrono::milliseconds(200))
            std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    return status;
}

Result bake_on(const std::string& url, const JobSpec& job, const Stop& stop, ProgressMode mode) {
    Api api(url, [&stop] { return stop.requested(); });
    try {
        const JobStatus status = wait_for(api, job, stop, mode);
        if (status.state != "done")
            throw Failure(Exit::failed,
                          status.error_code.empty() ? status.state : status.error_code,
                          "the job " + status.state + " on " + url +
                              (status.error_detail.empty() ? "" : ": " + status.error_detail));
        std::string image = api.image(status.id);
        return {std::move(image), api.report(status.id), url, status.cached};
    } catch (const Cancelled&) {
        abandon(url, job_id(job));
        stop.leave();
    }
}

Result bake_here(const JobSpec& job, const Stop& stop, ProgressMode mode) {
    keep_opencl_programs();
    pin_opencl_threads();
    ProgressView view(mode);
    // A server gives native the job at once and builds OpenCL beside it; one command has nothing
    // else to do.
    Engine engine({.device = job.device,
                   .opencl_wait = std::chrono::seconds(30),
                   .opencl_disabled_reason = "",
                   .thread_count = 0});
    const Control control{.progress =
                              [&](const Progress& p) {
                                  view.update({"running", p.fraction, p.standard_error_max});
                              },
                          .cancelled = [&stop] { return stop.requested(); }};
    try {
        Baked baked = kiln::bake(engine, job, control);
        return {std::move(baked.image), to_json(baked.report), "", false};
    } catch (const Cancelled&) {
        stop.leave();
    }
}

Result bake_anywhere(const BakeOptions& options, const JobSpec& job, const Stop& stop) {
    if (options.local) return bake_here(job, stop, options.progress);
    if (!options.server.empty()) return bake_on(options.server, job, stop, options.progress);
    // Nobody asked for a server: one that is there helps, and one that fails must not fail the
    // bake.
    std::string why = "no server at " + kDefaultServer;
    try {
        if (Api(kDefaultServer, [&stop] { return stop.requested(); }).answers())
            return bake_on(kDefaultServer, job, stop, options.progress);
    } catch (const Failure& failure) {
        if (failure.exit != Exit::unreachable) throw;
        why = failure.what();
    } catch (const Cancelled&) {
        stop.leave();
    }
    if (options.progress != ProgressMode::json)
        say("kiln: " + printable(why) + "; baking in this process");
    return bake_here(job, stop, options.progress);
}

}  // namespace

Exit bake(const BakeOptions& options) {
    check_arguments(options);
    const JobSpec job = load_job(options);
    const Interrupt interrupt(options.timeout_s);
    const Stop stop(interrupt, options.timeout_s);
    const Result result = bake_anywhere(options, job, stop);
    if (interrupt.requested()) stop.leave();

    write_output(options.output, result.image);
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
