// SPDX-License-Identifier: Apache-2.0
#include <sched.h>
#include <signal.h>
#include <sys/mount.h>
#include <sys/resource.h>

#include <atomic>
#include <thread>

#include "server/base/sha256.h"
#include "server/store/blob_store.h"
#include "server/store/job_store.h"
#include "tests/store/support.h"

namespace kiln::test {
namespace {

namespace fs = std::filesystem;

struct Usage {
    std::uint64_t bytes = 0;
    std::size_t entries = 0, temporary = 0, torn = 0;
};

/// Counts with std::filesystem, independently of the store.
Usage usage(const std::string& directory, bool verify) {
    Usage found;
    for (const auto& item : fs::recursive_directory_iterator(directory + "/cas.v1")) {
        if (!item.is_regular_file()) continue;
        const std::string name = item.path().filename();
        found.temporary += name.starts_with(".tmp.");
        if (name.size() != 64) continue;
        found.bytes += item.file_size();
        ++found.entries;
        if (verify && sha256_hex(read_file(item.path())) != name) ++found.torn;
    }
    return found;
}

std::string blob(std::mt19937::result_type seed, unsigned bytes_max = 60'000) {
    std::mt19937 random(seed);
    return random_bytes(random, 1 + random() % bytes_max);
}

// C1: whatever the moment, no torn entry, nothing acknowledged is lost, leftovers are removed.
TEST(DiskBlobFaults, KilledInMidPutLeavesNoTornEntry) {
    TemporaryFolder folder;
    const std::string directory = folder / "blobs";
    std::mt19937 random(3);
    std::size_t acknowledged_count = 0, leftovers = 0;
    for (unsigned round = 0; round < 60; ++round) {
        const auto put_all = [&](int out) {
            DiskBlobStore store(directory, 1 << 30);
            for (unsigned i = 0;; ++i) {
                const std::string digest = store.put(blob(round * 10'000 + i));
                if (write(out, digest.data(), digest.size()) < 0) return;
            }
        };
        const std::chrono::microseconds delay(random() % 16'000);
        const std::string digests = killed_child(put_all, delay, round % 4 == 3);
        leftovers += usage(directory, false).temporary;
        DiskBlobStore reopened(directory, 1 << 30);
        for (std::size_t i = 0; i + 64 <= digests.size(); i += 64) {
            const Bytes bytes = reopened.get(digests.substr(i, 64));
            ASSERT_NE(bytes, nullptr) << "acknowledged, then lost";
            ++acknowledged_count;
        }
    }
    const Usage left = usage(directory, true);
    EXPECT_EQ(left.torn, 0u);
    EXPECT_EQ(left.temporary, 0u);
    EXPECT_GE(left.entries, acknowledged_count);
    EXPECT_GE(acknowledged_count, 45u) << "three rounds of four wait for a first one";
    RecordProperty("temporary_files_found", static_cast<int>(leftovers));
}

// C7: eight threads, four times the budget.
TEST(DiskBlobFaults, EvictionUnderLoadKeepsTheBudgetAndEveryBody) {
    constexpr std::uint64_t kBudget = 2 << 20;
    constexpr unsigned kThreads = 8, kRounds = 6, kPutsEach = 6;
    TemporaryFolder folder;
    DiskBlobStore store(folder / "blobs", kBudget);
    std::atomic<int> wrong{0}, served{0};
    for (unsigned round = 0; round < kRounds; ++round) {
        {
            std::vector<std::jthread> threads;
            for (unsigned t = 0; t < kThreads; ++t)
                threads.emplace_back([&, t] {
                    for (unsigned i = 0; i < kPutsEach; ++i) {
                        // Neighbouring threads share some blobs.
                        const unsigned seed = round * 1000 + (t / 2 + i * 3) % 40;
                        store.put(blob(seed));
                        for (unsigned other = 0; other < 40; other += 5) {
                            const std::string expected = blob(round * 1000 + other);
                            const Bytes bytes = store.get(sha256_hex(expected));
                            if (bytes != nullptr) ++served;
                            if (bytes != nullptr && *bytes != expected) ++wrong;
                        }
                    }
                });
        }
        const Usage now = usage(folder / "blobs", true);
        EXPECT_LE(now.bytes, kBudget);
        EXPECT_EQ(now.torn, 0u);
        EXPECT_EQ(now.temporary, 0u);
        EXPECT_GE(store.stats().bytes, now.bytes) << "the count may err on the safe side only";
    }
    EXPECT_EQ(wrong, 0);
    EXPECT_GT(served, 0);
    EXPECT_GT(store.stats().evicted, 0u);
    EXPECT_EQ(store.stats().quarantined, 0u);
}

// C6: nobody is told of the other's puts, and still the budget holds and every body is right. Blobs
// of up to half the budget: two puts side by side that each fit alone are the hard case.
TEST(DiskBlobFaults, TwoProcessesShareOneFolder) {
    constexpr std::uint64_t kBudget = 1 << 20;
    for (const unsigned bytes_max : {60'000u, 500'000u}) {
        TemporaryFolder folder;
        const auto work = [&](unsigned first_seed) -> std::string {
            DiskBlobStore store(folder / "blobs", kBudget);
            std::mt19937 random(first_seed);
            int served = 0;
            for (int i = 0; i < 100; ++i) {
                store.put(blob(random() % 60, bytes_max));
                const std::string other = blob(random() % 60, bytes_max);
                const Bytes bytes = store.get(sha256_hex(other));
                if (bytes != nullptr && *bytes != other) return "a wrong body";
                served += bytes != nullptr;
            }
            if (store.stats().quarantined != 0) return "a good entry was set aside";
            return served > 0 ? "" : "nothing was ever found";
        };
        Child first([&] { return work(1); });
        Child second([&] { return work(2); });
        EXPECT_EQ(first.outcome(), "");
        EXPECT_EQ(second.outcome(), "");
        const Usage left = usage(folder / "blobs", true);
        EXPECT_LE(left.bytes, kBudget) << "blobs of up to " << bytes_max << " bytes";
        EXPECT_EQ(left.torn, 0u);
        EXPECT_EQ(left.temporary, 0u);
    }
}

// A disk of one megabyte in a mount namespace of this process alone, or, where that is not allowed,
// files of at most 256 kB.
bool make_small_disk(const std::string& path) {
    if (unshare(CLONE_NEWNS) == 0 &&
        mount(nullptr, "/", nullptr, MS_REC | MS_PRIVATE, nullptr) == 0 &&
        mount("tmpfs", path.c_str(), "tmpfs", 0, "size=1m") == 0)
        return true;
    signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{256 * 1024, 256 * 1024};
    return setrlimit(RLIMIT_FSIZE, &limit) == 0;
}

std::string fill_blobs(const std::string& directory) {
    DiskBlobStore store(directory, 1 << 30);
    const std::string kept = store.put("kept");
    std::mt19937 random(5);
    std::string refused;
    for (int i = 0; i < 20 && refused.empty(); ++i) {
        const std::string bytes = random_bytes(random, 300'000);
        const auto error = error_of([&] { store.put(bytes); });
        if (error[0].empty()) continue;
        if (error[0] != "store_failed" || error[1].find("write") == std::string::npos)
            return "the error is " + error[0] + ": " + error[1];
        refused = bytes;
    }
    if (refused.empty()) return "the disk never filled";
    const Usage left = usage(directory, true);
    if (left.torn + left.temporary != 0) return "something half-written stays";
    if (store.get(sha256_hex(refused)) != nullptr) return "a refused blob is served";
    if (store.get(kept) == nullptr) return "an older entry was lost";
    for (const auto& item : fs::recursive_directory_iterator(directory))
        if (item.is_regular_file() && item.file_size() > 1000) fs::remove(item);
    const std::string small = refused.substr(0, 100'000);
    return *store.get(store.put(small)) == small ? "" : "no recovery once there is room";
}

TEST(DiskBlobFaults, DiskFullIsAnErrorAndNothingHalfWrittenStays) {
    TemporaryFolder folder;
    EXPECT_EQ(in_child([&]() -> std::string {
                  if (!make_small_disk(folder.path())) return "no way to make a small disk";
                  return fill_blobs(folder / "blobs");
              }),
              "");
}

std::string fill_jobs(const std::string& path) {
    auto store = open_sqlite_job_store(path);
    const std::string spec(20'000, 'x');
    int accepted = 0;
    std::array<std::string, 2> error;
    while (error[0].empty() && accepted < 1000) {
        error = error_of([&] { store->submit("job" + std::to_string(accepted), spec, "e1"); });
        if (error[0].empty()) ++accepted;
    }
    if (error[0] != "store_failed") return "the disk never filled";
    if (error[1].find("submit") == std::string::npos &&
        error[1].find("commit") == std::string::npos)
        return "the error names no statement: " + error[1];
    if (store->get("job" + std::to_string(accepted))) return "a refused job is there";
    for (int i = 0; i < accepted; ++i)
        if (!store->get("job" + std::to_string(i))) return "an accepted job was lost";
    return store->counts().queued == accepted ? "" : "the counts are off";
}

TEST(DiskBlobFaults, DiskFullRefusesJobsByNameAndKeepsTheAcceptedOnes) {
    TemporaryFolder folder;
    EXPECT_EQ(in_child([&]() -> std::string {
                  if (!make_small_disk(folder.path())) return "no way to make a small disk";
                  return fill_jobs(folder / "jobs.db");
              }),
              "");
}

// C8: the acknowledgement comes after fsync of the file, rename, fsync of its folder, in this
// order.
TEST(DiskBlobFaults, AcknowledgedOnlyAfterFsyncRenameAndFsyncOfTheFolder) {
    TemporaryFolder folder;
    if (access("/usr/bin/strace", X_OK) != 0) GTEST_SKIP() << "strace is not installed";
    const std::string log = folder / "calls";
    // LeakSanitizer does not work under ptrace.
    const std::string command = "ASAN_OPTIONS=detect_leaks=0 /usr/bin/strace -f -y -o " + log +
                                " -e trace=fsync,rename,renameat,renameat2,write " +
                                STORE_PUT_PROGRAM + " " + (folder / "blobs") + " hello 2>/dev/null";
    FILE* pipe = popen(command.c_str(), "r");
    char printed[128] = {};
    const bool answered = fgets(printed, sizeof printed, pipe) != nullptr;
    pclose(pipe);
    const std::string calls = read_file(log);
    if (calls.empty()) GTEST_SKIP() << "strace may not trace here";
    ASSERT_TRUE(answered) << calls;
    const std::string digest = sha256_hex("hello");
    EXPECT_EQ(std::string(printed), digest + "\n");
    const std::string shard = "/cas.v1/" + digest.substr(0, 2);
    const std::string steps[] = {"\"hello\", 5", "fsync(",    "rename",  digest + "\"",
                                 "fsync(",       shard + ">", "write(1<"};
    std::size_t at = 0;
    for (const std::string& step : steps) {
        at = calls.find(step, at);
        ASSERT_NE(at, std::string::npos) << "no " << step << " in its place:\n" << calls;
        ++at;
    }
}

}  // namespace
}  // namespace kiln::test
