// SPDX-License-Identifier: Apache-2.0
#include <sqlite3.h>
#include <sys/stat.h>

#include <thread>

#include "tests/store/job_store_cases.h"

namespace kiln::test {
namespace {

/// A connection of the test's own, to look at the file and to damage it.
class Probe {
  public:
    explicit Probe(const std::string& path) { EXPECT_EQ(sqlite3_open(path.c_str(), &db_), 0); }
    ~Probe() { sqlite3_close(db_); }
    Probe(const Probe&) = delete;
    Probe& operator=(const Probe&) = delete;
    /// The first column of the last row.
    std::string ask(const std::string& sql) {
        std::string answer;
        const auto keep = [](void* out, int, char** values, char**) {
            *static_cast<std::string*>(out) = values[0] != nullptr ? values[0] : "";
            return 0;
        };
        char* message = nullptr;
        EXPECT_EQ(sqlite3_exec(db_, sql.c_str(), keep, &answer, &message), 0)
            << sql << ": " << (message != nullptr ? message : "");
        sqlite3_free(message);
        return answer;
    }

  private:
    sqlite3* db_ = nullptr;
};

class SqliteJobStoreTest : public testing::Test {
  protected:
    TemporaryFolder folder_;
    std::string path_ = folder_ / "state/jobs.db";
};

TEST_F(SqliteJobStoreTest, FolderIsPrivateAndTheFileIsWalAndStrict) {
    auto store = open_sqlite_job_store(path_);
    struct stat status {};
    ASSERT_EQ(stat((folder_ / "state").c_str(), &status), 0);
    EXPECT_EQ(status.st_mode & 0777, 0700u);
    Probe probe(path_);
    EXPECT_EQ(probe.ask("PRAGMA journal_mode"), "wal");
    EXPECT_EQ(probe.ask("PRAGMA user_version"), "1");
    EXPECT_EQ(probe.ask("SELECT count(*) FROM pragma_table_list "
                        "WHERE type = 'table' AND strict = 0 AND name NOT LIKE 'sqlite_%'"),
              "0");
}

TEST_F(SqliteJobStoreTest, NewerSchemaIsRefusedByName) {
    open_sqlite_job_store(path_)->submit("a", "{}", "e1");
    Probe(path_).ask("PRAGMA user_version = 7");
    const auto error = error_of([&] { open_sqlite_job_store(path_); });
    EXPECT_EQ(error[0], "store_failed");
    EXPECT_NE(error[1].find("schema 7"), std::string::npos) << error[1];
    EXPECT_EQ(Probe(path_).ask("SELECT count(*) FROM jobs"), "1");
}

TEST_F(SqliteJobStoreTest, ForeignDatabaseIsRefusedUntouched) {
    std::filesystem::create_directories(folder_ / "state");
    Probe(path_).ask("CREATE TABLE photos (name TEXT)");
    const std::string before = read_file(path_);
    const auto error = error_of([&] { open_sqlite_job_store(path_); });
    EXPECT_NE(error[1].find("did not make"), std::string::npos) << error[1];
    EXPECT_EQ(read_file(path_), before);
}

TEST_F(SqliteJobStoreTest, FileThatIsNoDatabaseIsRefused) {
    std::filesystem::create_directories(folder_ / "state");
    write_file(path_, std::string(8192, 'x'));
    const auto error = error_of([&] { open_sqlite_job_store(path_); });
    EXPECT_EQ(error[0], "store_failed");
    EXPECT_NE(error[1].find("not a database"), std::string::npos) << error[1];
}

TEST_F(SqliteJobStoreTest, DamagedPagesAreAnErrorThatNamesTheStatement) {
    auto store = open_sqlite_job_store(path_);
    for (int i = 0; i < 200; ++i) store->submit("job" + std::to_string(i), "{}", "e1");
    store = nullptr;
    const std::string good = read_file(path_);
    ASSERT_GT(good.size(), 8192u);
    // Every page but the first, which holds the header and the schema.
    write_file(path_, good.substr(0, 4096) + std::string(good.size() - 4096, '\x5a'));
    store = open_sqlite_job_store(path_);
    const auto error = error_of([&] { store->get("job7"); });
    EXPECT_EQ(error[0], "store_failed");
    EXPECT_NE(error[1].find("get: "), std::string::npos) << error[1];
    EXPECT_NE(error_of([&] { store->submit("new", "{}", "e1"); })[0], "");
}

TEST_F(SqliteJobStoreTest, BusyDatabaseIsAnErrorThatNamesTheStatementAndReadsGoOn) {
    auto store = open_sqlite_job_store(path_);
    store->submit("a", "{}", "e1");
    Probe other(path_);
    other.ask("BEGIN IMMEDIATE");
    EXPECT_TRUE(store->get("a"));
    EXPECT_FALSE(store->submit("a", "{}", "e1").created);
    EXPECT_EQ(store->counts().queued, 1);
    const auto error = error_of([&] { store->claim("w", hours(1), 3); });  // after 5 s
    EXPECT_EQ(error[0], "store_failed");
    EXPECT_NE(error[1].find("claim: database is locked"), std::string::npos) << error[1];
    other.ask("COMMIT");
    EXPECT_TRUE(store->claim("w", hours(1), 3));
}

TEST_F(SqliteJobStoreTest, MachineRestartedEndsEveryLease) {
    auto store = open_sqlite_job_store(path_);
    store->submit("a", "{}", "e1");
    const JobRecord job = store->claim("w", hours(1), 3).value();
    EXPECT_FALSE(store->claim("w", hours(1), 3));
    Probe(path_).ask("UPDATE jobs SET lease_boot = 'an earlier boot'");
    EXPECT_EQ(store->claim("w", hours(1), 3).value().attempts, job.attempts + 1);
}

// Wall-clock times in the rows are for display: ten years to either side change no lease.
TEST_F(SqliteJobStoreTest, WallClockJumpsChangeNoLease) {
    auto store = open_sqlite_job_store(path_);
    for (const char* jump : {"+315360000000", "-315360000000"}) {
        const std::string id = std::string("a") + jump;
        store->submit(id, "{}", "e1");
        const JobRecord job = store->claim("w", hours(1), 3).value();
        Probe(path_).ask(std::string("UPDATE jobs SET created_ms = created_ms ") + jump +
                         ", started_ms = started_ms " + jump);
        EXPECT_FALSE(store->claim("w", hours(1), 3)) << "a held lease ended";
        store->renew(id, job.attempts, milliseconds(0), 0.5, {});
        EXPECT_TRUE(store->claim("w", hours(1), 3)) << "a lease that ran out never ends";
    }
}

TEST_F(SqliteJobStoreTest, OldestFinishedJobsAreForgottenBeyondTheBound) {
    auto store = open_sqlite_job_store(path_, 3);
    store->submit("waiting", "{}", "e1");
    const JobRecord held = store->claim("w", hours(1), 3).value();
    for (int i = 0; i < 10; ++i) {
        const std::string id = "job" + std::to_string(i);
        store->submit(id, "{}", "e1");
        const JobRecord job = store->claim("w", hours(1), 3).value();
        ASSERT_TRUE(store->finish(id, job.attempts, "digest", "exr", "{}"));
        std::this_thread::sleep_for(milliseconds(2));  // finished_ms tells them apart
    }
    store->submit("last", "{}", "e1");
    EXPECT_EQ(store->counts().done, 3);
    EXPECT_FALSE(store->get("job6"));
    EXPECT_TRUE(store->get("job7"));
    EXPECT_TRUE(store->get("job9"));
    EXPECT_TRUE(store->finish(held.id, held.attempts, "digest", "exr", "{}")) << "unfinished stay";
    EXPECT_EQ(error_of([&] { open_sqlite_job_store(path_, 0); })[0], "store_failed");
}

TEST_F(SqliteJobStoreTest, ManyProcessesOpenANewFileAtOnce) {
    constexpr int kProcesses = 8;
    int gate[2];  // all wait at its end until this process closes it
    ASSERT_EQ(pipe(gate), 0);
    std::vector<std::unique_ptr<Child>> children;
    for (int i = 0; i < kProcesses; ++i)
        children.push_back(std::make_unique<Child>([&, i]() -> std::string {
            close(gate[1]);
            char nothing;
            if (read(gate[0], &nothing, 1) != 0) return "the gate is broken";
            open_sqlite_job_store(path_)->submit("job" + std::to_string(i), "{}", "e1");
            return "";
        }));
    close(gate[0]);
    close(gate[1]);
    for (const auto& child : children) EXPECT_EQ(child->outcome(), "");
    EXPECT_EQ(open_sqlite_job_store(path_)->counts().queued, kProcesses);
}

// kill -9 at any moment: what was acknowledged is there and the file is whole.
TEST_F(SqliteJobStoreTest, KilledWhileSubmittingLosesNoAcknowledgedJob) {
    std::mt19937 random(1);
    std::vector<std::string> acknowledged;
    for (int round = 0; round < 20; ++round) {
        const auto submit_all = [&](int out) {
            auto store = open_sqlite_job_store(path_);
            for (int i = 0;; ++i) {
                const std::string id = std::to_string(round) + "." + std::to_string(i);
                store->submit(id, "{}", "e1");
                const std::string line = id + "\n";
                if (write(out, line.data(), line.size()) < 0) return;
            }
        };
        const std::chrono::microseconds delay(random() % 20'000);
        const std::string lines = killed_child(submit_all, delay, round % 4 == 3);
        std::istringstream text(lines);
        for (std::string id; std::getline(text, id);) acknowledged.push_back(id);
    }
    ASSERT_GE(acknowledged.size(), 15u) << "three rounds of four wait for a first one";
    auto store = open_sqlite_job_store(path_);
    for (const std::string& id : acknowledged) EXPECT_TRUE(store->get(id)) << id;
    EXPECT_EQ(Probe(path_).ask("PRAGMA integrity_check"), "ok");
    EXPECT_EQ(std::to_string(store->counts().queued),
              Probe(path_).ask("SELECT count(*) FROM jobs"));
}

}  // namespace
}  // namespace kiln::test
