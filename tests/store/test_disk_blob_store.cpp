// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>

#include <thread>

#include "server/base/sha256.h"
#include "server/store/blob_store.h"
#include "tests/store/support.h"

namespace kiln::test {
namespace {

namespace fs = std::filesystem;

class DiskBlobStoreTest : public testing::Test {
  protected:
    static constexpr std::uint64_t kBudget = 1 << 20;
    std::string entry(const std::string& digest) const {
        return folder_ / ("blobs/cas.v1/" + digest.substr(0, 2) + "/" + digest);
    }
    std::size_t quarantined_files() const {
        const fs::path path = folder_ / "blobs/cas.v1/quarantine";
        return static_cast<std::size_t>(
            std::distance(fs::directory_iterator(path), fs::directory_iterator()));
    }
    void age(const std::string& digest, int seconds) const {
        timespec times[2] = {{0, UTIME_OMIT}, {time(nullptr) - seconds, 0}};
        ASSERT_EQ(utimensat(AT_FDCWD, entry(digest).c_str(), times, 0), 0);
    }
    // What is in place of the entry is never served, does not block, and a put repairs it.
    void expect_absent_then_repaired(const std::string& bytes, const std::string& what) {
        const std::string digest = sha256_hex(bytes);
        EXPECT_EQ(store_.get(digest), nullptr) << what;
        EXPECT_EQ(store_.put(bytes), digest) << what;
        const Bytes repaired = store_.get(digest);
        ASSERT_NE(repaired, nullptr) << what;
        EXPECT_EQ(*repaired, bytes) << what;
    }

    TemporaryFolder folder_;
    DiskBlobStore store_{folder_ / "blobs", kBudget};
    std::mt19937 random_{7};
};

TEST_F(DiskBlobStoreTest, BytesComeBackUnderTheirDigest) {
    // SHA-256 of "abc": FIPS 180-2, appendix B.1.
    const std::string abc = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
    EXPECT_FALSE(store_.contains(abc));
    EXPECT_EQ(store_.get(abc), nullptr);
    EXPECT_EQ(store_.put("abc"), abc);
    EXPECT_TRUE(store_.contains(abc));
    EXPECT_EQ(*store_.get(abc), "abc");
    EXPECT_EQ(read_file(entry(abc)), "abc");
    for (const std::string& bytes : {std::string(), random_bytes(random_, 300'000)})
        EXPECT_EQ(*store_.get(store_.put(bytes)), bytes);
    struct stat status {};
    ASSERT_EQ(stat((folder_ / "blobs").c_str(), &status), 0);
    EXPECT_EQ(status.st_mode & 0777, 0700u);
}

TEST_F(DiskBlobStoreTest, NameThatIsNoDigestNeverReachesThePath) {
    for (const std::string name :
         {"", "..", "../../etc/passwd", "ba7816bf", "quarantine",
          "BA7816BF8F01CFEA414140DE5DAE2223B00361A396177A9CB410FF61F20015AD",
          "../7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"}) {
        EXPECT_EQ(error_of([&] { store_.get(name); })[0], "store_failed") << name;
        EXPECT_EQ(error_of([&] { store_.contains(name); })[0], "store_failed") << name;
    }
}

TEST_F(DiskBlobStoreTest, ThousandFlippedBitsAreNeverServed) {
    const std::string bytes = random_bytes(random_, 4096);
    const std::string digest = store_.put(bytes);
    for (int i = 0; i < 1000; ++i) {
        std::string flipped = bytes;
        flipped[random_() % flipped.size()] ^= static_cast<char>(1 << (random_() % 8));
        write_file(entry(digest), flipped);
        ASSERT_EQ(store_.get(digest), nullptr) << i;
        ASSERT_FALSE(fs::exists(entry(digest))) << "wrong bytes must be set aside";
    }
    EXPECT_EQ(store_.stats().quarantined, 1000u);
    EXPECT_EQ(quarantined_files(), 16u) << "and only the last of them kept";
    expect_absent_then_repaired(bytes, "flips");
}

TEST_F(DiskBlobStoreTest, CutAtEveryPercentIsNeverServed) {
    const std::string bytes = random_bytes(random_, 10'000);
    const std::string digest = store_.put(bytes);
    for (std::size_t percent = 0; percent < 100; ++percent) {
        write_file(entry(digest), bytes.substr(0, bytes.size() * percent / 100));
        ASSERT_EQ(store_.get(digest), nullptr) << percent << " %";
    }
    write_file(entry(digest), bytes + "x");
    EXPECT_EQ(store_.get(digest), nullptr) << "one byte more";
    write_file(entry(digest), bytes.substr(0, 100));
    EXPECT_EQ(store_.put(bytes), digest) << "a put over a damaged entry";
    EXPECT_EQ(*store_.get(digest), bytes);
}

TEST_F(DiskBlobStoreTest, SwappedEntriesAreNeverServed) {
    const std::string a = random_bytes(random_, 1000), b = random_bytes(random_, 1000);
    const std::string digest_a = store_.put(a), digest_b = store_.put(b);
    fs::rename(entry(digest_a), folder_ / "swap");
    fs::rename(entry(digest_b), entry(digest_a));
    fs::rename(folder_ / "swap", entry(digest_b));
    expect_absent_then_repaired(a, "a");
    expect_absent_then_repaired(b, "b");
}

TEST_F(DiskBlobStoreTest, ThingsThatAreNoRegularFileCountAsAbsent) {
    const std::string bytes = "these very bytes";
    const std::string digest = store_.put(bytes);
    const std::string path = entry(digest);
    write_file(folder_ / "outside", bytes);

    fs::remove(path);
    fs::create_symlink(folder_ / "outside", path);
    EXPECT_FALSE(store_.contains(digest));
    expect_absent_then_repaired(bytes, "a link to the right bytes");
    EXPECT_EQ(read_file(folder_ / "outside"), bytes) << "nothing is written through a link";

    fs::remove(path);
    ASSERT_EQ(mkfifo(path.c_str(), 0600), 0);
    EXPECT_FALSE(store_.contains(digest));
    expect_absent_then_repaired(bytes, "a FIFO without a writer");

    fs::remove(path);
    fs::create_directories(path + "/inner");
    EXPECT_FALSE(store_.contains(digest));
    expect_absent_then_repaired(bytes, "a directory that is not empty");
}

TEST_F(DiskBlobStoreTest, ShardThatIsNoDirectoryCountsAsAbsentAndAMissingOneIsMadeAgain) {
    const std::string bytes = "abc";
    const std::string digest = store_.put(bytes);
    const fs::path shard = fs::path(entry(digest)).parent_path();
    fs::remove_all(shard);
    expect_absent_then_repaired(bytes, "removed");
    fs::remove_all(shard);
    write_file(shard, "a file");
    EXPECT_EQ(store_.get(digest), nullptr);
    EXPECT_EQ(error_of([&] { store_.put(bytes); })[0], "store_failed");
}

TEST_F(DiskBlobStoreTest, UnreadableEntryIsAnErrorAndStays) {
    if (geteuid() == 0) {
        // The superuser reads everything; RLIMIT_NOFILE stops everybody.
        const std::string digest = store_.put("abc");
        const std::string message = in_child([&]() -> std::string {
            std::vector<int> taken;
            for (int fd; (fd = open("/dev/null", O_RDONLY)) >= 0;) taken.push_back(fd);
            const auto error = error_of([&] { store_.get(digest); });
            for (int fd : taken) close(fd);
            if (error[0] != "store_failed") return "no error without descriptors";
            return *store_.get(digest) == "abc" ? "" : "lost";
        });
        EXPECT_EQ(message, "");
        return;
    }
    const std::string digest = store_.put("abc");
    fs::permissions(entry(digest), fs::perms::none);
    EXPECT_EQ(error_of([&] { store_.get(digest); })[0], "store_failed");
    fs::permissions(entry(digest), fs::perms::owner_read);
    EXPECT_EQ(*store_.get(digest), "abc");
}

TEST_F(DiskBlobStoreTest, ForeignFilesAreLeftAlone) {
    const std::string shard = folder_ / "blobs/cas.v1/ab/";
    const std::string foreign[] = {shard + "README", shard + std::string(64, 'G'),
                                   folder_ / "blobs/cas.v1/note",
                                   shard + std::string(64, '0')};  // 00… does not belong into ab/
    for (const std::string& path : foreign) write_file(path, std::string(kBudget, 'x'));
    DiskBlobStore again(folder_ / "blobs", kBudget);
    EXPECT_EQ(again.stats().count, 0u);
    again.put(random_bytes(random_, kBudget));
    for (const std::string& path : foreign) EXPECT_EQ(fs::file_size(path), kBudget) << path;
}

TEST_F(DiskBlobStoreTest, AbandonedTemporaryFilesAreRemovedAtOpenAndLiveOnesKept) {
    const std::string dead = folder_ / "blobs/cas.v1/ab/.tmp.4194303.0";
    const std::string live = folder_ / "blobs/cas.v1/ab/.tmp.4194303.1";
    write_file(dead, "half");
    write_file(live, "half");
    const int held = open(live.c_str(), O_WRONLY);
    ASSERT_EQ(flock(held, LOCK_EX | LOCK_NB), 0);
    DiskBlobStore again(folder_ / "blobs", kBudget);
    EXPECT_FALSE(fs::exists(dead));
    EXPECT_TRUE(fs::exists(live));
    close(held);
}

TEST_F(DiskBlobStoreTest, BlobLargerThanTheBudgetIsRefusedWithBothNumbers) {
    const auto error = error_of([&] { store_.put(std::string(kBudget + 1, 'x')); });
    EXPECT_EQ(error[0], "store_failed");
    EXPECT_NE(error[1].find("1048577"), std::string::npos) << error[1];
    EXPECT_NE(error[1].find("1048576"), std::string::npos) << error[1];
    const std::string largest(kBudget, 'x');
    EXPECT_EQ(*store_.get(store_.put(largest)), largest);
}

TEST_F(DiskBlobStoreTest, LeastRecentlyUsedGoFirstUntilATenthIsFree) {
    std::vector<std::string> digests;
    for (int i = 0; i < 10; ++i) {
        digests.push_back(store_.put(random_bytes(random_, kBudget / 10)));
        age(digests.back(), 1000 - i);
    }
    store_.get(digests[0]);  // a read, a question and a repeated put are uses
    store_.contains(digests[1]);
    store_.put(*store_.get(digests[2]));
    const std::string next = store_.put(random_bytes(random_, kBudget / 10));
    EXPECT_EQ(store_.stats().evicted, 2u);
    EXPECT_FALSE(store_.contains(digests[3]));
    EXPECT_FALSE(store_.contains(digests[4]));
    for (std::size_t kept : {0u, 1u, 2u, 5u, 9u}) EXPECT_TRUE(store_.contains(digests[kept]));
    EXPECT_TRUE(store_.contains(next));
}

TEST_F(DiskBlobStoreTest, SmallerBudgetIsMetAtOpen) {
    for (int i = 0; i < 10; ++i) store_.put(random_bytes(random_, kBudget / 10));
    DiskBlobStore smaller(folder_ / "blobs", kBudget / 2);
    EXPECT_LE(smaller.stats().bytes, kBudget / 2);
    EXPECT_GT(smaller.stats().count, 0u);
}

// Neither store knows of the other's puts.
TEST_F(DiskBlobStoreTest, TwoWritersTogetherStayWithinTheBudget) {
    DiskBlobStore other(folder_ / "blobs", kBudget);
    for (int i = 0; i < 60; ++i) {
        (i % 2 == 0 ? store_ : other).put(random_bytes(random_, kBudget / 20));
        std::uint64_t bytes = 0;
        for (const auto& item : fs::recursive_directory_iterator(folder_ / "blobs"))
            if (item.is_regular_file()) bytes += item.file_size();
        ASSERT_LE(bytes, kBudget) << i;
    }
}

TEST_F(DiskBlobStoreTest, StatsSeeWhatOthersPut) {
    DiskBlobStore other(folder_ / "blobs", kBudget);
    other.put(std::string(1000, 'x'));
    EXPECT_EQ(other.stats().bytes, 1000u);
    EXPECT_EQ(other.stats().count, 1u);
    other.put(std::string(1000, 'x'));
    EXPECT_EQ(other.stats().count, 1u) << "the same bytes are one entry";
    std::this_thread::sleep_for(std::chrono::milliseconds(1100));  // figures may be a second old
    EXPECT_EQ(store_.stats().bytes, 1000u);
}

}  // namespace
}  // namespace kiln::test
