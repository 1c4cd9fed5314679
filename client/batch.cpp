// SPDX-License-Identifier: Apache-2.0
#include "client/batch.h"

#include <algorithm>

#include "client/api.h"
#include "client/commands.h"
#include "client/files.h"
#include "server/compute/kernel_digest.h"
#include "server/compute/opencl_threads.h"
#include "server/image/image.h"
#include "server/spec/limits.h"
#include "server/worker/bake.h"

namespace kiln::client {

namespace {

constexpr double kPollWaitS = 0.5;

/// Tells of many jobs as of one: the part that is done.
class Overall {
  public:
    Overall(ProgressMode mode, std::size_t count) : view_(mode), count_(count) {}
    void update(std::size_t done, double fraction) {
        view_.update({"running",
                      (static_cast<double>(done) + fraction) /
                          static_cast<double>(std::max<std::size_t>(count_, 1)),
                      std::nullopt});
    }

  private:
    ProgressView view_;
    std::size_t count_;
};

class RemoteBakery final : public Bakery {
  public:
    RemoteBakery(const std::string& url, const Stop& stop, ProgressMode mode)
        : api_(url, [&stop] { return stop.requested(); }), stop_(stop), mode_(mode) {}

    std::string engine() override { return api_.engine(); }
    std::string where() const override { return api_.url(); }

    std::vector<BakedJob> bake(const std::vector<JobSpec>& jobs) override {
        Overall overall(mode_, jobs.size());
        std::vector<JobStatus> taken;
        std::vector<BakedJob> baked;
        try {
            const auto batch_max = static_cast<std::size_t>(limits().batch_jobs_max);
            for (std::size_t first = 0; first < jobs.size(); first += batch_max) {
                std::vector<std::string> batch;
                for (std::size_t i = first; i < std::min(first + batch_max, jobs.size()); ++i)
                    batch.push_back(canonical(jobs[i]));
                for (JobStatus& status : api_.submit_batch(batch))
                    taken.push_back(std::move(status));
            }
            for (const JobStatus& status : taken) {
                baked.push_back(fetch(status, overall, baked.size()));
            }
        } catch (const Cancelled&) {
            for (std::size_t i = baked.size(); i < taken.size(); ++i) abandon(taken[i].id);
            stop_.leave();
        }
        return baked;
    }

  private:
    BakedJob fetch(JobStatus status, Overall& overall, std::size_t done) {
        const bool cached = status.cached;
        while (status.state == "queued" || status.state == "running") {
            overall.update(done, status.progress);
            if (stop_.requested()) throw Cancelled();
            status = api_.status(status.id, kPollWaitS);
        }
        if (status.state != "done")
            throw Failure(Exit::failed,
                          status.error_code.empty() ? status.state : status.error_code,
                          "a job " + status.state + " on " + api_.url() +
                              (status.error_detail.empty() ? "" : ": " + status.error_detail));
        std::string image = api_.image(status.id);
        return {std::move(image), api_.report(status.id), cached};
    }

    void abandon(const std::string& id) {
        const auto give_up = std::chrono::steady_clock::now() + std::chrono::seconds(2);
        Api api(api_.url(), [give_up] { return std::chrono::steady_clock::now() > give_up; });
        try {
            api.cancel(id);
        } catch (const Error&) {  // best effort: the reason for leaving is what the user hears
        }
    }

    Api api_;
    const Stop& stop_;
    ProgressMode mode_;
};

class LocalBakery final : public Bakery {
  public:
    LocalBakery(const Stop& stop, ProgressMode mode) : stop_(stop), mode_(mode) {}

    std::string engine() override {
        return kernel_digest() + "/" + std::to_string(kEncoderRevision);
    }
    std::string where() const override { return ""; }

    std::vector<BakedJob> bake(const std::vector<JobSpec>& jobs) override {
        Overall overall(mode_, jobs.size());
        std::vector<BakedJob> baked;
        const Control control{
            .progress = [&](const Progress& p) { overall.update(baked.size(), p.fraction); },
            .cancelled = [this] { return stop_.requested(); }};
        try {
            for (const JobSpec& job : jobs) {
                Baked one = kiln::bake(engine_for(job), job, control);
                baked.push_back({std::move(one.image), to_json(one.report), false});
            }
        } catch (const Cancelled&) {
            stop_.leave();
        }
        return baked;
    }

  private:
    /// Tables of a scene take milliseconds; "auto" takes OpenCL where its program is at hand.
    Engine& engine_for(const JobSpec& job) {
        const bool native = job.device == DeviceChoice::native;
        auto& engine = native ? native_ : any_;
        if (engine) return *engine;
        if (!native) {
            keep_opencl_programs();
            pin_opencl_threads();
        }
        engine.emplace(
            EngineOptions{.device = native ? DeviceChoice::native : DeviceChoice::automatic,
                          .opencl_wait = std::chrono::milliseconds(0),
                          .opencl_disabled_reason = "",
                          .thread_count = 0});
        return *engine;
    }

    const Stop& stop_;
    ProgressMode mode_;
    std::optional<Engine> native_, any_;
};

}  // namespace

std::unique_ptr<Bakery> open_bakery(const std::string& server, bool local, const Stop& stop,
                                    ProgressMode mode) {
    if (local) return std::make_unique<LocalBakery>(stop, mode);
    if (!server.empty()) return std::make_unique<RemoteBakery>(server, stop, mode);
    try {
        if (Api(kDefaultServer, [&stop] { return stop.requested(); }).answers())
            return std::make_unique<RemoteBakery>(kDefaultServer, stop, mode);
    } catch (const Cancelled&) {
        stop.leave();
    }
    if (mode != ProgressMode::json)
        say("kiln: no server at " + kDefaultServer + "; baking in this process");
    return std::make_unique<LocalBakery>(stop, mode);
}

}  // namespace kiln::client
