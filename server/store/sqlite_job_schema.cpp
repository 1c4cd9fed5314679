// SPDX-License-Identifier: Apache-2.0
#include "server/store/sqlite_job_schema.h"

#include <chrono>
#include <thread>

#include "server/base/error.h"

namespace kiln {

namespace {

constexpr int kSchemaVersion = 1;

// `attempts` only ever grows, also when a job is queued afresh, so that no token is given twice;
// attempts - attempts_before counts the claims of the present submission.
// lease_until_ms is on the monotonic clock of the boot named by lease_boot (sqlite_job_store.cpp).
// `tally` keeps the counts by state, so that admission need not count a hundred thousand rows.
constexpr const char* kSchema = R"sql(
CREATE TABLE jobs (
  sequence INTEGER PRIMARY KEY,
  id TEXT NOT NULL UNIQUE,
  spec TEXT NOT NULL,
  engine TEXT NOT NULL,
  state TEXT NOT NULL CHECK (state IN ('queued', 'running', 'done', 'failed', 'cancelled')),
  progress REAL NOT NULL DEFAULT 0 CHECK (progress BETWEEN 0 AND 1),
  standard_error_max REAL,
  attempts INTEGER NOT NULL DEFAULT 0,
  attempts_before INTEGER NOT NULL DEFAULT 0,
  note TEXT NOT NULL DEFAULT '',
  cancel_requested INTEGER NOT NULL DEFAULT 0,
  worker TEXT NOT NULL DEFAULT '',
  lease_until_ms INTEGER NOT NULL DEFAULT 0,
  lease_boot TEXT NOT NULL DEFAULT '',
  image_digest TEXT NOT NULL DEFAULT '',
  image_extension TEXT NOT NULL DEFAULT '',
  report TEXT NOT NULL DEFAULT '',
  error_code TEXT NOT NULL DEFAULT '',
  error_detail TEXT NOT NULL DEFAULT '',
  created_ms INTEGER NOT NULL,
  started_ms INTEGER NOT NULL DEFAULT 0,
  finished_ms INTEGER NOT NULL DEFAULT 0
) STRICT;
CREATE INDEX jobs_created ON jobs (created_ms);
CREATE INDEX jobs_state_created ON jobs (state, created_ms);
CREATE INDEX jobs_running ON jobs (worker) WHERE state = 'running';
CREATE INDEX jobs_finished ON jobs (finished_ms) WHERE finished_ms > 0;
CREATE TABLE tally (state TEXT PRIMARY KEY, jobs INTEGER NOT NULL) STRICT, WITHOUT ROWID;
INSERT INTO tally VALUES
  ('queued', 0), ('running', 0), ('done', 0), ('failed', 0), ('cancelled', 0);
CREATE TRIGGER jobs_inserted AFTER INSERT ON jobs BEGIN
  UPDATE tally SET jobs = jobs + 1 WHERE state = new.state;
END;
CREATE TRIGGER jobs_moved AFTER UPDATE OF state ON jobs WHEN old.state <> new.state BEGIN
  UPDATE tally SET jobs = jobs - 1 WHERE state = old.state;
  UPDATE tally SET jobs = jobs + 1 WHERE state = new.state;
END;
CREATE TRIGGER jobs_removed AFTER DELETE ON jobs BEGIN
  UPDATE tally SET jobs = jobs - 1 WHERE state = old.state;
END;
PRAGMA application_id = 1265200238; -- "Kiln" in ASCII
PRAGMA user_version = 1;
)sql";

std::int64_t ask(Database& database, const char* name, const char* sql) {
    Statement statement(database, name, sql);
    Rows rows = statement.run();
    std::int64_t value = 0;
    while (rows.next()) value = rows.integer(0);
    return value;
}

// Inside a transaction, or another process may create the tables between the two questions.
std::int64_t known_version(Database& database, const std::string& path) {
    const std::int64_t version = ask(database, "read schema version", "PRAGMA user_version");
    if (version > kSchemaVersion)
        throw Error("store_failed",
                    "job store: " + path + " has schema " + std::to_string(version) +
                        "; this Kiln knows schemas up to " + std::to_string(kSchemaVersion) +
                        ". Use the newer Kiln, or another data directory");
    const char* tables = "SELECT count(*) FROM sqlite_schema";
    if (version == 0 && ask(database, "look for tables", tables) > 0)
        throw Error("store_failed",
                    "job store: " + path + " is an SQLite database that Kiln did not make");
    return version;
}

// Two processes that open a new file at once: the switch to WAL needs the file for itself and
// reports "locked" without asking the busy handler now and then.
void switch_to_wal(Database& database) {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(5);
    for (;;) {
        try {
            database.execute("switch to WAL", "PRAGMA journal_mode = WAL");
            return;
        } catch (const Error&) {
            if (!database.busy() || std::chrono::steady_clock::now() > deadline) throw;
            std::this_thread::sleep_for(std::chrono::milliseconds(5));
        }
    }
}

}  // namespace

void prepare_job_schema(Database& database, const std::string& path) {
    {
        Transaction transaction(database);  // a refused file must not even change its mode
        known_version(database, path);
        transaction.commit();
    }
    switch_to_wal(database);
    database.execute("set synchronous", "PRAGMA synchronous = FULL");
    // Bounds what a burst leaves behind in the -wal file: 16 MiB.
    database.execute("set journal size", "PRAGMA journal_size_limit = 16777216");
    Transaction transaction(database);
    if (known_version(database, path) == 0) database.execute("create schema", kSchema);
    transaction.commit();
}

}  // namespace kiln
