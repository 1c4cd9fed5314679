// SPDX-License-Identifier: Apache-2.0
#include "client/run_job.h"

#include <chrono>
#include <thread>

#include "client/api.h"
#include "client/files.h"
#include "server/compute/opencl_threads.h"
#include "server/spec/kinds.h"
#include "server/spec/spec.h"
#include "server/worker/bake.h"

namespace kiln::client {

namespace {

// A long-poll returns when the job ends; between, this is how often progress is seen.
constexpr double kPollWaitS = 0.5;
constexpr double kQuietWaitS = 20;  // where nobody watches

/// Best effort: the reason for leaving is what the user hears, not that the server was gone too.
void abandon(const std::string& url, const std::string& id) {
    const auto give_up = std::chrono::steady_clock::now() + std::chrono::seconds(2);
    Api api(url, [give_up] { return std::chrono::steady_clock::now() > give_up; });
    try {
        api.cancel(id);
    } catch (const Error&) {
    }
}

JobStatus wait_for(Api& api, const JobSpec& job, const Stop& stop, ProgressMode mode,
                   const MeasurementFiles& files) {
    upload_missing(api, job, files);
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

Baking bake_on(const std::string& url, const JobSpec& job, const Stop& stop, ProgressMode mode,
               const MeasurementFiles& files) {
    Api api(url, [&stop] { return stop.requested(); });
    try {
        const JobStatus status = wait_for(api, job, stop, mode, files);
        if (status.state != "done")
            throw Failure(Exit::failed,
                          status.error_code.empty() ? status.state : status.error_code,
                          "the job " + status.state + " on " + url +
                              (status.error_detail.empty() ? "" : ": " + status.error_detail));
        std::string image = api.image(status.id);
        std::string sidecar = is_measured(job.kind) ? api.sidecar(status.id) : "";
        return {std::move(image), api.report(status.id), std::move(sidecar), url, status.cached};
    } catch (const Cancelled&) {
        abandon(url, job_id(job));
        stop.leave();
    }
}

Baking bake_here(const JobSpec& job, const Stop& stop, ProgressMode mode,
                 const MeasurementFiles& files) {
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
        Baked baked = kiln::bake(engine, job, control, [&files](const std::string& digest) {
            return files.bytes(digest);
        });
        std::string report = report_json(baked);
        return {std::move(baked.image), std::move(report), std::move(baked.sidecar), "", false};
    } catch (const Cancelled&) {
        stop.leave();
    }
}

}  // namespace

Baking run_job(const RunOptions& options, const JobSpec& job, const Stop& stop,
               const MeasurementFiles& files) {
    if (options.local) return bake_here(job, stop, options.progress, files);
    if (!options.server.empty()) return bake_on(options.server, job, stop, options.progress, files);
    // Nobody asked for a server: one that is there helps, and one that fails must not fail the
    // bake.
    std::string why = "no server at " + kDefaultServer;
    try {
        if (Api(kDefaultServer, [&stop] { return stop.requested(); }).answers())
            return bake_on(kDefaultServer, job, stop, options.progress, files);
    } catch (const Failure& failure) {
        if (failure.exit != Exit::unreachable) throw;
        why = failure.what();
    } catch (const Cancelled&) {
        stop.leave();
    }
    if (options.progress != ProgressMode::json)
        say("kiln: " + printable(why) + "; baking in this process");
    return bake_here(job, stop, options.progress, files);
}

}  // namespace kiln::client
