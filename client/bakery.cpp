// SPDX-License-Identifier: Apache-2.0
#include "client/bakery.h"

#include <algorithm>
#include <map>
#include <span>
#include <thread>

#include "client/api.h"
#include "client/files.h"
#include "server/compute/kernel_digest.h"
#include "server/compute/opencl_threads.h"
#include "server/image/image.h"
#include "server/measured/reader.h"
#include "server/spec/kinds.h"
#include "server/spec/limits.h"
#include "server/spec/spec.h"
#include "server/worker/bake.h"

namespace kiln::client {

namespace {

using namespace std::chrono_literals;

// A long-poll returns when the job ends; between, this is how often progress is seen.
constexpr double kPollWaitS = 0.5;
constexpr double kQuietWaitS = 20;  // where nobody watches

/// Tells of many jobs as of one: the part that is done.
class Overall {
  public:
    Overall(ProgressMode mode, std::size_t count) : view_(mode), count_(count) {}
    void update(std::size_t done, Stage stage) {
        const auto count = static_cast<double>(std::max<std::size_t>(count_, 1));
        stage.fraction = (static_cast<double>(done) + stage.fraction) / count;
        if (done > 0) stage.state = "running";
        if (count_ > 1) stage.standard_error_max.reset();  // of one job among many
        view_.update(stage);
    }

  private:
    ProgressView view_;
    std::size_t count_;
};

class RemoteBakery final : public Bakery {
  public:
    RemoteBakery(const std::string& url, const Stop& stop, ProgressMode mode)
        : api_(url, [&stop] { return stop.requested(); }), stop_(stop), mode_(mode) {}

    Makers makers() override { return api_.makers(); }
    bool has_measurement(const std::string& digest) override {
        return api_.has_measurement(digest);
    }
    std::string where() const override { return api_.url(); }

    std::vector<Baking> bake(const std::vector<JobSpec>& jobs,
                             const MeasurementFiles& files) override {
        Overall overall(mode_, jobs.size());
        std::vector<Baking> baked;
        try {
            for (const JobSpec& job : jobs) upload_missing(api_, job, files);
            const std::vector<JobStatus> taken = submit(jobs);
            for (const JobStatus& status : taken)
                baked.push_back(fetch(status, jobs[baked.size()], overall, baked.size()));
        } catch (const Cancelled&) {
            abandon(std::span(jobs).subspan(baked.size()));
            stop_.leave();
        }
        return baked;
    }

  private:
    std::vector<JobStatus> submit(const std::vector<JobSpec>& jobs) {
        if (jobs.size() == 1) return {api_.submit(canonical(jobs[0]), kPollWaitS)};
        std::vector<JobStatus> taken;
        const auto batch_max = static_cast<std::size_t>(limits().batch_jobs_max);
        for (std::size_t first = 0; first < jobs.size(); first += batch_max) {
            std::vector<std::string> batch;
            for (std::size_t i = first; i < std::min(first + batch_max, jobs.size()); ++i)
                batch.push_back(canonical(jobs[i]));
            for (JobStatus& status : api_.submit_batch(batch)) taken.push_back(std::move(status));
        }
        return taken;
    }

    Baking fetch(JobStatus status, const JobSpec& job, Overall& overall, std::size_t done) {
        const double wait_s = mode_ == ProgressMode::none ? kQuietWaitS : kPollWaitS;
        // A later answer calls cached what has ended by then, this client's own job among it.
        const bool cached = status.cached;
        while (status.state == "queued" || status.state == "running") {
            overall.update(done, {status.state, status.progress, status.standard_error_max});
            if (stop_.requested()) throw Cancelled();
            const auto asked = std::chrono::steady_clock::now();
            status = api_.status(status.id, wait_s);
            // A server that is short of long-polls may answer at once; it is not to be asked in a
            // tight loop.
            while (status.state != "done" && !stop_.requested() &&
                   std::chrono::steady_clock::now() - asked < 200ms)
                std::this_thread::sleep_for(20ms);
        }
        if (status.state != "done")
            throw Failure(Exit::failed,
                          status.error_code.empty() ? status.state : status.error_code,
                          "the job " + status.state + " on " + api_.url() +
                              (status.error_detail.empty() ? "" : ": " + status.error_detail));
        std::string image = api_.image(status.id);
        std::string sidecar = is_measured(job.kind) ? api_.sidecar(status.id) : "";
        return {std::move(image), api_.report(status.id), std::move(sidecar), api_.url(), cached};
    }

    /// Best effort: the reason for leaving is what the user hears, not that the server was gone
    /// too.
    void abandon(std::span<const JobSpec> jobs) {
        const auto give_up = std::chrono::steady_clock::now() + 2s;
        Api api(api_.url(), [give_up] { return std::chrono::steady_clock::now() > give_up; });
        for (const JobSpec& job : jobs) try {
                api.release(job_id(job));
            } catch (const Error&) {
            }
    }

    Api api_;
    const Stop& stop_;
    ProgressMode mode_;
};

class LocalBakery final : public Bakery {
  public:
    LocalBakery(const Stop& stop, ProgressMode mode, std::chrono::milliseconds opencl_wait)
        : stop_(stop), mode_(mode), opencl_wait_(opencl_wait) {}

    Makers makers() override {
        const std::string tables = kernel_digest() + "/" + std::to_string(kEncoderRevision);
        return {tables, tables + "/" + std::to_string(measured::kReaderRevision)};
    }
    bool has_measurement(const std::string&) override { return false; }
    std::string where() const override { return ""; }

    std::vector<Baking> bake(const std::vector<JobSpec>& jobs,
                             const MeasurementFiles& files) override {
        Overall overall(mode_, jobs.size());
        std::vector<Baking> baked;
        const Control control{
            .progress =
                [&](const Progress& p) {
                    overall.update(baked.size(), {"running", p.fraction, p.standard_error_max});
                },
            .cancelled = [this] { return stop_.requested(); }};
        try {
            for (const JobSpec& job : jobs) {
                Baked one =
                    kiln::bake(engine_for(job.device), job, control,
                               [&files](const std::string& digest) { return files.bytes(digest); });
                std::string report = report_json(one);
                baked.push_back(
                    {std::move(one.image), std::move(report), std::move(one.sidecar), "", false});
            }
        } catch (const Cancelled&) {
            stop_.leave();
        }
        return baked;
    }

  private:
    Engine& engine_for(DeviceChoice device) {
        const auto found = engines_.find(device);
        if (found != engines_.end()) return *found->second;
        if (device != DeviceChoice::native && !threads_pinned_) {
            keep_opencl_programs();
            pin_opencl_threads();
            threads_pinned_ = true;
        }
        const EngineOptions options{.device = device,
                                    .opencl_wait = opencl_wait_,
                                    .opencl_disabled_reason = "",
                                    .thread_count = 0};
        return *engines_.emplace(device, std::make_unique<Engine>(options)).first->second;
    }

    const Stop& stop_;
    ProgressMode mode_;
    std::chrono::milliseconds opencl_wait_;
    bool threads_pinned_ = false;
    std::map<DeviceChoice, std::unique_ptr<Engine>> engines_;
};

std::unique_ptr<Bakery> in_this_process(const RunOptions& options, const std::string& why,
                                        const Stop& stop, std::chrono::milliseconds opencl_wait) {
    if (!why.empty() && options.progress != ProgressMode::json)
        say("kiln: " + printable(why) + "; baking in this process");
    return std::make_unique<LocalBakery>(stop, options.progress, opencl_wait);
}

}  // namespace

std::unique_ptr<Bakery> open_bakery(const RunOptions& options, const Stop& stop,
                                    std::chrono::milliseconds opencl_wait) {
    if (options.local) return in_this_process(options, "", stop, opencl_wait);
    if (!options.server.empty())
        return std::make_unique<RemoteBakery>(options.server, stop, options.progress);
    try {
        if (Api(kDefaultServer, [&stop] { return stop.requested(); }).answers())
            return std::make_unique<RemoteBakery>(kDefaultServer, stop, options.progress);
    } catch (const Cancelled&) {
        stop.leave();
    }
    return in_this_process(options, "no server at " + kDefaultServer, stop, opencl_wait);
}

Baking run_job(const RunOptions& options, const JobSpec& job, const Stop& stop,
               const MeasurementFiles& files) {
    // A server gives native the job at once and builds OpenCL beside it; one command has nothing
    // else to do.
    constexpr auto kOpenClWait = 30s;
    const auto bakery = open_bakery(options, stop, kOpenClWait);
    try {
        return bakery->bake({job}, files).front();
    } catch (const Failure& failure) {
        const bool asked_for = !options.server.empty() || bakery->where().empty();
        if (asked_for || failure.exit != Exit::unreachable) throw;
        return in_this_process(options, failure.what(), stop, kOpenClWait)
            ->bake({job}, files)
            .front();
    }
}

}  // namespace kiln::client
