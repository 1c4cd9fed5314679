// SPDX-License-Identifier: Apache-2.0
#include <charconv>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <tuple>

#include "server/base/error.h"
#include "server/store/job_store.h"
#include "server/store/posix_file.h"
#include "server/store/sqlite.h"
#include "server/store/sqlite_job_schema.h"
#include "server/store/sqlite_job_text.h"

namespace kiln {

namespace {

std::int64_t clock_ms(clockid_t clock) {
    timespec now{};
    clock_gettime(clock, &now);
    return std::int64_t{now.tv_sec} * 1000 + now.tv_nsec / 1'000'000;
}

std::int64_t unix_ms() { return clock_ms(CLOCK_REALTIME); }

// Leases run on the clock that all processes of a machine share and nobody can set. It starts anew
// with each boot, so a lease also names its boot; one from an earlier boot has no living holder.
// SQLite's WAL keeps all users of a file on one machine, therefore one such clock is enough.
std::int64_t lease_clock_ms() { return clock_ms(CLOCK_MONOTONIC); }

std::string boot_id() {
    const char* path = "/proc/sys/kernel/random/boot_id";
    std::ifstream file(path);
    std::string id;
    if (!(file >> id)) throw Error("store_failed", std::string("job store: cannot read ") + path);
    return id;
}

JobRecord read_job(const Rows& row) {
    JobRecord job;
    int column = 0;
    job.id = row.text(column++);
    job.spec = row.text(column++);
    job.engine = row.text(column++);
    job.state = job_state_from(row.text(column++)).value();
    job.progress = row.real(column++);
    if (!row.null(column)) job.standard_error_max = row.real(column);
    ++column;
    job.attempts = static_cast<int>(row.integer(column++));
    job.note = row.text(column++);
    job.cancel_requested = row.integer(column++) != 0;
    job.worker = row.text(column++);
    job.image_digest = row.text(column++);
    job.image_extension = row.text(column++);
    job.report = row.text(column++);
    job.error_code = row.text(column++);
    job.error_detail = row.text(column++);
    job.created_ms = row.integer(column++);
    job.started_ms = row.integer(column++);
    job.finished_ms = row.integer(column);
    return job;
}

std::optional<JobRecord> read_one(Rows rows) {
    std::optional<JobRecord> job;
    while (rows.next()) job = read_job(rows);
    return job;
}

// (created_ms, sequence) of the last row of a page, as two hexadecimal numbers.
struct Cursor {
    std::int64_t created_ms = 0, sequence = 0;
};

std::string to_text(const Cursor& cursor) {
    char text[40];
    char* end = std::to_chars(text, text + 16, cursor.created_ms, 16).ptr;
    *end++ = '-';
    end = std::to_chars(end, text + sizeof text, cursor.sequence, 16).ptr;
    return {text, end};
}

Cursor cursor_from(const std::string& text) {
    Cursor cursor;
    const char* end = text.data() + text.size();
    auto [first, first_error] = std::from_chars(text.data(), end, cursor.created_ms, 16);
    bool good = first_error == std::errc() && first != end && *first == '-';
    if (good) {
        auto [second, second_error] = std::from_chars(first + 1, end, cursor.sequence, 16);
        good = second_error == std::errc() && second == end;
    }
    // One spelling a cursor: signs, leading zeros and capitals are not ours.
    if (!good || cursor.created_ms < 0 || cursor.sequence < 0 || to_text(cursor) != text)
        throw Error("bad_cursor", "the cursor is not one that a list of jobs returned");
    return cursor;
}

// Two connections, each behind its mutex: in WAL mode a reader never waits for a writer, so asking
// for a job costs microseconds even while another thread waits for the disk. More readers would
// gain little: a read holds its mutex for about 10 µs.
struct Writer {
    explicit Writer(const std::string& path) : database(path) {
        prepare_job_schema(database, path);
    }
    std::mutex mutex;
    Database database;
};

struct WriteStatements {
    explicit WriteStatements(Database& d)
        : submit(d, "submit", text::submit()),
          join(d, "submit (join)", text::kJoin),
          get(d, "submit (read)", text::get()),
          prune(d, "submit (prune)", text::kPrune),
          claim(d, "claim", text::claim()),
          renew(d, "renew", text::kRenew),
          finish(d, "finish", text::kFinish),
          fail(d, "fail", text::kFail),
          cancelled(d, "cancelled", text::kCancelled),
          cancel(d, "cancel", text::kCancel),
          release(d, "release", text::kRelease) {}
    Statement submit, join, get, prune, claim, renew, finish, fail, cancelled, cancel, release;
};

struct Reader {
    explicit Reader(const std::string& path)
        : database(path),
          get(database, "get", text::get()),
          list(database, "list", text::list(false)),
          list_state(database, "list by state", text::list(true)),
          counts(database, "counts", text::kCounts) {
        database.execute("set query_only", "PRAGMA query_only = ON");
    }
    std::mutex mutex;
    Database database;
    Statement get, list, list_state, counts;
};

const std::string& with_directory(const std::string& path) {
    make_private_directory(std::filesystem::absolute(path).parent_path().string());
    return path;
}

class SqliteJobStore final : public JobStore {
  public:
    SqliteJobStore(const std::string& path, std::int64_t finished_max)
        : finished_max_(finished_max),
          boot_(boot_id()),
          writer_(with_directory(path)),
          write_(writer_.database),
          reader_(path) {}

    Submitted submit(const std::string& id, const std::string& spec, const std::string& engine,
                     bool again) override;
    std::optional<JobRecord> get(const std::string& id) override;
    std::optional<JobRecord> claim(const std::string& worker, std::chrono::milliseconds lease,
                                   int attempts_max) override;
    Renewal renew(const std::string& id, int attempt, std::chrono::milliseconds lease,
                  double progress, std::optional<double> standard_error_max) override;
    bool finish(const std::string& id, int attempt, const std::string& image_digest,
                const std::string& image_extension, const std::string& report) override;
    bool fail(const std::string& id, int attempt, const std::string& code,
              const std::string& detail) override;
    bool cancelled(const std::string& id, int attempt) override;
    CancelResult cancel(const std::string& id) override;
    int release(const std::string& worker, const std::string& note) override;
    JobPage list(std::optional<JobState> state, int limit, const std::string& cursor) override;
    JobCounts counts() override;

  private:
    // Rows written by one run of a statement.
    template <class... Values>
    std::int64_t write(Statement& statement, const Values&... values) {
        std::lock_guard lock(writer_.mutex);
        statement.run(values...).finish();
        return writer_.database.changes();
    }

    std::int64_t finished_max_;
    std::string boot_;
    Writer writer_;
    WriteStatements write_;
    Reader reader_;
};

bool nothing_to_write(const JobRecord& job, const std::string& engine, bool again) {
    switch (job.state) {
        case JobState::queued:
            return job.engine == engine;
        case JobState::running:
            return !job.cancel_requested;
        case JobState::done:
            return job.engine == engine && !again;
        default:
            return false;
    }
}

Submitted SqliteJobStore::submit(const std::string& id, const std::string& spec,
                                 const std::string& engine, bool again) {
    // The usual case, a cached result, takes no write lock.
    if (auto known = get(id); known && nothing_to_write(*known, engine, again))
        return {std::move(*known), false};
    std::lock_guard lock(writer_.mutex);
    Transaction transaction(writer_.database);
    auto fresh = read_one(write_.submit.run(id, spec, engine, unix_ms(), again ? 1 : 0));
    Submitted submitted;
    submitted.created = fresh.has_value();
    if (submitted.created) {
        submitted.job = std::move(*fresh);
        write_.prune.run(finished_max_).finish();
    } else {
        write_.join.run(id, engine).finish();
        submitted.job = read_one(write_.get.run(id)).value();
    }
    transaction.commit();
    return submitted;
}

std::optional<JobRecord> SqliteJobStore::get(const std::string& id) {
    std::lock_guard lock(reader_.mutex);
    return read_one(reader_.get.run(id));
}

std::optional<JobRecord> SqliteJobStore::claim(const std::string& worker,
                                               std::chrono::milliseconds lease, int attempts_max) {
    std::lock_guard lock(writer_.mutex);
    for (;;) {
        const std::int64_t now = lease_clock_ms();
        auto job = read_one(
            write_.claim.run(worker, unix_ms(), now, boot_, now + lease.count(), attempts_max));
        // A job that this claim failed or cancelled is not what the caller asked for.
        if (!job || job->state == JobState::running) return job;
    }
}

Renewal SqliteJobStore::renew(const std::string& id, int attempt, std::chrono::milliseconds lease,
                              double progress, std::optional<double> standard_error_max) {
    // SQLite would store a NaN as "not known".
    if (standard_error_max && std::isnan(*standard_error_max))
        throw Error("store_failed", "job store: renew: standard_error_max is not a number");
    std::lock_guard lock(writer_.mutex);
    Rows rows = write_.renew.run(id, attempt, lease_clock_ms() + lease.count(), boot_, progress,
                                 standard_error_max);
    Renewal renewal = Renewal::lost;
    while (rows.next()) renewal = rows.integer(0) != 0 ? Renewal::cancel_requested : Renewal::held;
    return renewal;
}

bool SqliteJobStore::finish(const std::string& id, int attempt, const std::string& image_digest,
                            const std::string& image_extension, const std::string& report) {
    return write(write_.finish, id, attempt, unix_ms(), image_digest, image_extension, report) == 1;
}

bool SqliteJobStore::fail(const std::string& id, int attempt, const std::string& code,
                          const std::string& detail) {
    return write(write_.fail, id, attempt, unix_ms(), code, detail) == 1;
}

bool SqliteJobStore::cancelled(const std::string& id, int attempt) {
    return write(write_.cancelled, id, attempt, unix_ms()) == 1;
}

CancelResult SqliteJobStore::cancel(const std::string& id) {
    {
        std::lock_guard lock(writer_.mutex);
        Rows rows = write_.cancel.run(id, unix_ms());
        std::optional<CancelResult> result;
        while (rows.next())
            result = rows.integer(0) != 0 ? CancelResult::requested : CancelResult::cancelled;
        if (result) return *result;
    }
    return get(id) ? CancelResult::already_finished : CancelResult::unknown;
}

int SqliteJobStore::release(const std::string& worker, const std::string& note) {
    return static_cast<int>(write(write_.release, worker, note, unix_ms()));
}

JobPage SqliteJobStore::list(std::optional<JobState> state, int limit, const std::string& cursor) {
    if (limit < 1)
        throw Error("bad_limit", "a page holds at least one job, not " + std::to_string(limit));
    constexpr std::int64_t kLast = INT64_MAX;
    const Cursor from = cursor.empty() ? Cursor{kLast, kLast} : cursor_from(cursor);
    std::lock_guard lock(reader_.mutex);
    Rows rows = state ? reader_.list_state.run(from.created_ms, from.sequence,
                                               std::int64_t{limit} + 1, to_word(*state))
                      : reader_.list.run(from.created_ms, from.sequence, std::int64_t{limit} + 1);
    JobPage page;
    Cursor last;
    while (rows.next()) {
        if (page.jobs.size() == static_cast<std::size_t>(limit)) {
            page.next_cursor = to_text(last);
            continue;
        }
        page.jobs.push_back(read_job(rows));
        last = {page.jobs.back().created_ms, rows.integer(text::kSequenceColumn)};
    }
    return page;
}

JobCounts SqliteJobStore::counts() {
    std::lock_guard lock(reader_.mutex);
    Rows rows = reader_.counts.run(unix_ms());
    JobCounts counts;
    while (rows.next()) {
        counts.queued = rows.integer(0);
        counts.running = rows.integer(1);
        counts.done = rows.integer(2);
        counts.failed = rows.integer(3);
        counts.cancelled = rows.integer(4);
        counts.oldest_queued_ms = rows.integer(5);
    }
    return counts;
}

}  // namespace

std::unique_ptr<JobStore> open_sqlite_job_store(const std::string& path,
                                                std::int64_t finished_max) {
    if (finished_max < 1)
        throw Error("store_failed", "job store: at least one finished job must be kept");
    return std::make_unique<SqliteJobStore>(path, finished_max);
}

}  // namespace kiln
