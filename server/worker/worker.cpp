// SPDX-License-Identifier: Apache-2.0
#include "server/worker/worker.h"

#include <malloc.h>
#include <unistd.h>

#include <array>
#include <new>

#include "server/base/error.h"
#include "server/base/log.h"
#include "server/compute/devices_json.h"
#include "server/compute/report.h"
#include "server/spec/spec.h"
#include "server/store/measurement_store.h"
#include "server/worker/attempt.h"
#include "server/worker/bake.h"
#include "server/worker/engines.h"
#include "server/worker/mailbox.h"
#include "server/worker/watchdog.h"

namespace kiln {

namespace {

constexpr std::chrono::milliseconds kPoll{1000};

/// Free memory that stays with the process between jobs: fresh pages cost a table of 256² some
/// 4 ms. Blocks beyond kMappedBytes go back to the system at once.
constexpr std::size_t kKeptBytes = 64 << 20;
constexpr int kMappedBytes = 8 << 20;

void keep_small_memory() {
    mallopt(M_MMAP_THRESHOLD, kMappedBytes);
    mallopt(M_TRIM_THRESHOLD, static_cast<int>(kKeptBytes));
}

void give_back_big_memory() {
    if (mallinfo2().fordblks > kKeptBytes) malloc_trim(0);
}

std::string own_name() {
    std::array<char, 256> host{};
    gethostname(host.data(), host.size() - 1);
    return std::string(host.data()) + "-" + std::to_string(getpid());
}

class Worker {
  public:
    Worker(const Settings& settings, JobStore& jobs, BlobStore& blobs)
        : settings_(settings),
          jobs_(jobs),
          blobs_(blobs),
          name_(settings.worker_name.empty() ? own_name() : settings.worker_name),
          lease_(std::chrono::seconds(settings.lease_s)),
          mailbox_(static_cast<int>(settings.doorbell_fd)),
          watchdog_(mailbox_, std::chrono::seconds(settings.stall_s)),
          engines_(settings) {}

    int run() {
        bool devices_told = false;
        while (mailbox_.stop() == Mailbox::Stop::none) {
            std::optional<JobRecord> job;
            try {
                job = jobs_.claim(name_, lease_, static_cast<int>(settings_.attempts_max));
            } catch (const Error& failure) {
                log_line("claim_failed", {{"worker", name_}, {"detail", failure.what()}});
            }
            if (job) {
                work_on(*job);
            } else if (!devices_told) {  // it may take a while, so a waiting job goes first
                const Watched watched(watchdog_);
                mailbox_.say("devices " + to_json(engines_.pick("").devices()));
                devices_told = true;
            } else {
                mailbox_.wait(kPoll);
                engines_.refresh();
            }
        }
        return 0;
    }

  private:
    void work_on(const JobRecord& job) {
        mailbox_.say("state " + job.id);
        Attempt attempt(jobs_, mailbox_, job, lease_);
        try {
            const Watched watched(watchdog_, attempt);
            bake_and_store(job, attempt);
        } catch (const Cancelled&) {
            if (attempt.state() == Attempt::State::dropped) give_back(job);
        } catch (const std::bad_alloc&) {
            fail(job, "out_of_memory", "there was not enough memory for this job");
        } catch (const Error& failure) {
            fail(job, failure.code(), failure.what());
        } catch (const std::exception& failure) {
            log_line("job_failed", {{"job", job.id}, {"detail", failure.what()}});
            fail(job, "internal", "an unexpected failure; the server's log has the reason");
        }
        mailbox_.say("state " + job.id);
        give_back_big_memory();
    }

    void bake_and_store(const JobRecord& job, Attempt& attempt) {
        const JobSpec spec = parse_job(job.spec);
        Control control;
        control.progress = [&](const Progress& progress) { attempt.progress(progress); };
        control.cancelled = [&] { return attempt.look() != Attempt::State::running; };
        Baked baked =
            bake(engines_.pick(job.note), spec, control, [this](const std::string& digest) {
                return measurement_bytes(settings_.data_dir, digest);
            });
        if (control.cancelled()) throw Cancelled();
        const std::string digest = blobs_.put(baked.image);
        RunTime& time = baked.report.run_time_s;
        time.queued = static_cast<double>(job.started_ms - job.created_ms) / 1000;
        time.total += time.queued;
        if (!jobs_.finish(job.id, job.attempts, digest, baked.extension, report_json(baked)))
            log_line("attempt_lost", {{"job", job.id}, {"worker", name_}});
    }

    void give_back(const JobRecord& job) {
        try {
            jobs_.release(name_, "");
        } catch (const Error& failure) {
            log_line("release_failed", {{"job", job.id}, {"detail", failure.what()}});
        }
    }

    void fail(const JobRecord& job, const std::string& code, const std::string& detail) {
        try {
            jobs_.fail(job.id, job.attempts, code, detail);
        } catch (const Error& failure) {
            // The lease runs out and another attempt follows.
            log_line("fail_not_stored", {{"job", job.id}, {"detail", failure.what()}});
        }
    }

    const Settings& settings_;
    JobStore& jobs_;
    BlobStore& blobs_;
    const std::string name_;
    const std::chrono::milliseconds lease_;
    Mailbox mailbox_;
    Watchdog watchdog_;
    Engines engines_;
};

}  // namespace

int run_worker(const Settings& settings, JobStore& jobs, BlobStore& blobs) {
    keep_small_memory();
    Worker worker(settings, jobs, blobs);
    return worker.run();
}

}  // namespace kiln
