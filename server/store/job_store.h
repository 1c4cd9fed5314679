// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/store/bounds.h"

namespace kiln {

enum class JobState { queued, running, done, failed, cancelled };

struct JobRecord {
    std::string id;      ///< job_id of spec
    std::string spec;    ///< canonical job text
    std::string engine;  ///< kernel digest + encoder revision that a finished result came from, or
                         ///< that is asked for
    JobState state = JobState::queued;
    double progress = 0;                       ///< 0…1
    std::optional<double> standard_error_max;  ///< so far
    /// Claims so far; also the fencing token of the running attempt. It never falls, not even when
    /// the job is queued afresh: a token given twice would let a stale worker in. A first try has
    /// note "".
    int attempts = 0;
    std::string note;  ///< why an earlier attempt ended, "" when there was none
    bool cancel_requested = false;
    std::string worker;
    std::string image_digest, image_extension, report;  ///< set when done; report is JSON text
    std::string error_code, error_detail;               ///< set when failed or cancelled
    std::int64_t created_ms = 0, started_ms = 0, finished_ms = 0;  ///< Unix time, for display only
};

struct Submitted {
    JobRecord job;
    bool created = false;  ///< false: the same job was known and is waited for, running or done
};

enum class Renewal { held, cancel_requested, lost };
enum class CancelResult { cancelled, requested, already_finished, unknown };

struct JobPage {
    std::vector<JobRecord> jobs;  ///< newest first; report left empty
    std::string next_cursor;      ///< "" on the last page
};

struct JobCounts {
    std::int64_t queued = 0, running = 0, done = 0, failed = 0, cancelled = 0;
    std::int64_t oldest_queued_ms = 0;  ///< age of the oldest queued job, 0 where none waits
};

/// The durable queue and record of jobs. Every call is one short transaction and safe from any
/// thread and process; a call that returned has reached the disk. A claimed job carries a lease:
/// whoever holds it renews in time, and any worker may claim a job whose lease ran out. Every later
/// call names the attempt it belongs to, so that a worker that lost its lease can never overwrite
/// another's result. Leases are measured on the monotonic clock, so that setting the wall clock
/// neither ends nor prolongs one. Throws Error("store_failed") naming the statement.
class JobStore {
  public:
    virtual ~JobStore() = default;

    /// Idempotent by id. A job that failed, was cancelled, or is done under another engine is
    /// queued afresh; `again` queues a done one too (its blob was evicted). Submitting a running
    /// job withdraws a cancel request: somebody waits for it again.
    virtual Submitted submit(const std::string& id, const std::string& spec,
                             const std::string& engine, bool again = false) = 0;
    virtual std::optional<JobRecord> get(const std::string& id) = 0;
    /// The oldest job that is queued or whose lease ran out. A job with `attempts_max` attempts
    /// fails instead, with its note as detail (error_code "attempts_exhausted"); only attempts
    /// since it was last submitted afresh count. A job whose cancel was requested becomes cancelled
    /// instead.
    virtual std::optional<JobRecord> claim(const std::string& worker,
                                           std::chrono::milliseconds lease, int attempts_max) = 0;
    virtual Renewal renew(const std::string& id, int attempt, std::chrono::milliseconds lease,
                          double progress, std::optional<double> standard_error_max) = 0;
    /// False: the attempt is no longer the current one and nothing was written. The same holds for
    /// the next two.
    virtual bool finish(const std::string& id, int attempt, const std::string& image_digest,
                        const std::string& image_extension, const std::string& report) = 0;
    virtual bool fail(const std::string& id, int attempt, const std::string& code,
                      const std::string& detail) = 0;
    /// The running attempt stopped because of a cancel request. Where that was withdrawn meanwhile,
    /// the job is queued again.
    virtual bool cancelled(const std::string& id, int attempt) = 0;
    virtual CancelResult cancel(const std::string& id) = 0;
    /// A worker died: its running jobs go back to the queue with `note`. Returns how many.
    virtual int release(const std::string& worker, const std::string& note) = 0;
    /// limit ≥ 1, which the caller bounds; cursor as returned earlier, "" for the first page.
    /// Throws Error("bad_cursor").
    virtual JobPage list(std::optional<JobState> state, int limit, const std::string& cursor) = 0;
    virtual JobCounts counts() = 0;
};

std::string_view to_word(JobState state);
std::optional<JobState> job_state_from(std::string_view word);

/// SQLite in WAL mode, synchronous = FULL, at `path` (created when absent, its directory with mode
/// 0700). Beyond `finished_max` ≥ 1 finished jobs, the first finished are forgotten as new ones
/// come.
std::unique_ptr<JobStore> open_sqlite_job_store(const std::string& path,
                                                std::int64_t finished_max = kFinishedJobsMax);

}  // namespace kiln
