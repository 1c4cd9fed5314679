// SPDX-License-Identifier: Apache-2.0
#include <atomic>
#include <barrier>
#include <map>
#include <mutex>
#include <thread>

#include "server/base/sha256.h"
#include "server/store/blob_store.h"
#include "tests/store/support.h"

namespace kiln::test {
namespace {

/// A disk store that counts the reads that reach it, and can fail them.
class CountingStore : public BlobStore {
  public:
    explicit CountingStore(const std::string& directory) : disk_(directory, 1 << 30) {}
    std::string put(std::string_view bytes) override { return disk_.put(bytes); }
    Bytes get(const std::string& digest) override {
        ++gets;
        if (delay.count() > 0) std::this_thread::sleep_for(delay);
        if (failing) throw Error("store_failed", "the disk is gone");
        return disk_.get(digest);
    }
    bool contains(const std::string& digest) override { return disk_.contains(digest); }
    std::optional<std::uint64_t> size(const std::string& digest) override {
        return disk_.size(digest);
    }

    std::atomic<int> gets{0};
    std::atomic<bool> failing{false};
    std::chrono::milliseconds delay{0};

  private:
    DiskBlobStore disk_;
};

class CachedBlobStoreTest : public testing::Test {
  protected:
    static constexpr std::uint64_t kBudget = 100'000, kLooseBudget = 200'000;
    std::string put(char letter, std::size_t byte_count) {
        return cached_.put(std::string(byte_count, letter));
    }
    int reads(const std::string& digest) {
        const int before = below_.gets;
        EXPECT_NE(cached_.get(digest), nullptr);
        return below_.gets - before;
    }

    TemporaryFolder folder_;
    CountingStore below_{folder_ / "blobs"};
    CachedBlobStore cached_{below_, kBudget, kLooseBudget};
};

TEST_F(CachedBlobStoreTest, HotBlobIsReadOnceAndNotCopied) {
    const std::string digest = put('a', 20'000);
    const Bytes first = cached_.get(digest);
    const Bytes second = cached_.get(digest);
    EXPECT_EQ(below_.gets, 1);
    EXPECT_EQ(*first, std::string(20'000, 'a'));
    EXPECT_EQ(first.get(), second.get());
}

TEST_F(CachedBlobStoreTest, LeastRecentlyUsedGoFirst) {
    std::vector<std::string> digests;
    for (char letter = 'a'; letter <= 'd'; ++letter) {
        digests.push_back(put(letter, 24'000));
        EXPECT_EQ(reads(digests.back()), 1);
    }
    EXPECT_EQ(reads(digests[0]), 0);  // now b is the oldest; four entries fill the budget
    const std::string next = put('e', 24'000);
    EXPECT_EQ(reads(next), 1);
    EXPECT_EQ(reads(digests[0]), 0);
    EXPECT_EQ(reads(digests[2]), 0);
    EXPECT_EQ(reads(digests[3]), 0);
    EXPECT_EQ(reads(digests[1]), 1) << "evicted";
}

TEST_F(CachedBlobStoreTest, BlobAboveAQuarterOfTheBudgetPassesThrough) {
    const std::string small = put('a', 20'000);
    reads(small);
    const std::string large = put('b', kBudget / 4 + 1);
    EXPECT_EQ(reads(large), 1);
    EXPECT_EQ(reads(large), 1) << "not kept";
    EXPECT_EQ(reads(small), 0) << "and pushes nothing out";
    const Bytes held = cached_.get(large);
    EXPECT_EQ(reads(large), 0) << "shared while somebody uses it";
}

TEST_F(CachedBlobStoreTest, BytesInUseOutliveTheirEviction) {
    const Bytes held = cached_.get(put('a', 24'000));
    for (char letter = 'b'; letter <= 'z'; ++letter) cached_.get(put(letter, 24'000));
    EXPECT_EQ(*held, std::string(24'000, 'a'));
}

TEST_F(CachedBlobStoreTest, WhatCallersHoldBesideTheCacheIsBounded) {
    const std::string first = put('a', 90'000), second = put('b', 90'000), third = put('c', 90'000);
    const std::string small = put('d', 1'000);
    const Bytes held = cached_.get(first);
    Bytes other = cached_.get(second);
    EXPECT_EQ(error_of([&] { cached_.get(third); })[0], "too_many_downloads");
    EXPECT_NE(cached_.get(first), nullptr) << "shared with who holds it";
    EXPECT_NE(cached_.get(small), nullptr);
    EXPECT_NE(cached_.get(small), nullptr) << "the cache's own is not counted";
    other.reset();
    EXPECT_NE(cached_.get(third), nullptr) << "a place that came free";
}

TEST_F(CachedBlobStoreTest, EvictedBytesInUseCount) {
    // Eight in callers' hands, of which the cache keeps four.
    std::vector<Bytes> held;
    for (char letter = 'a'; letter < 'i'; ++letter)
        held.push_back(cached_.get(put(letter, 24'000)));
    const std::string large = put('z', 120'000);
    EXPECT_EQ(error_of([&] { cached_.get(large); })[0], "too_many_downloads");
    held.clear();
    EXPECT_NE(cached_.get(large), nullptr);
}

TEST_F(CachedBlobStoreTest, OneBlobLargerThanEveryBudgetPasses) {
    const std::string large = put('a', kBudget + kLooseBudget), next = put('b', 90'000);
    const Bytes held = cached_.get(large);
    EXPECT_NE(held, nullptr);
    EXPECT_EQ(error_of([&] { cached_.get(next); })[0], "too_many_downloads");
}

TEST_F(CachedBlobStoreTest, AbsentStaysAbsentAndIsAskedForAgain) {
    const std::string digest = sha256_hex("later");
    EXPECT_EQ(cached_.get(digest), nullptr);
    EXPECT_FALSE(cached_.contains(digest));
    cached_.put("later");
    EXPECT_EQ(*cached_.get(digest), "later");
    EXPECT_TRUE(cached_.contains(digest));
}

TEST_F(CachedBlobStoreTest, FailedReadIsTheErrorOfAllWhoWaitAndIsNotKept) {
    const std::string digest = put('a', 1000), hot = put('b', 1000);
    cached_.get(hot);
    below_.failing = true;
    EXPECT_EQ(error_of([&] { cached_.get(digest); })[0], "store_failed");
    EXPECT_NE(cached_.get(hot), nullptr) << "hot bytes need no disk";
    below_.failing = false;
    EXPECT_NE(cached_.get(digest), nullptr);
}

TEST_F(CachedBlobStoreTest, CrowdForOneColdBlobIsOneRead) {
    constexpr int kThreads = 32;
    below_.delay = std::chrono::milliseconds(50);
    for (std::size_t byte_count : {1000u, 90'000u}) {  // kept, and passing through
        const std::string digest = put('a', byte_count);
        below_.gets = 0;
        std::barrier start(kThreads);
        std::barrier end(kThreads);
        std::atomic<int> good{0};
        {
            std::vector<std::jthread> threads;
            for (int i = 0; i < kThreads; ++i)
                threads.emplace_back([&] {
                    start.arrive_and_wait();
                    const Bytes bytes = cached_.get(digest);
                    good += bytes != nullptr && bytes->size() == byte_count;
                    end.arrive_and_wait();  // holds the bytes until all have them
                });
        }
        EXPECT_EQ(good, kThreads);
        EXPECT_EQ(below_.gets, 1) << byte_count;
    }
}

TEST_F(CachedBlobStoreTest, ManyThreadsGetTheRightBytes) {
    std::map<std::string, char> letters;
    for (char letter = 'a'; letter <= 'p'; ++letter) letters[put(letter, 20'000)] = letter;
    std::atomic<int> wrong{0};
    {
        std::vector<std::jthread> threads;
        for (unsigned t = 0; t < 8; ++t)
            threads.emplace_back([&, t] {
                std::mt19937 random(t);
                for (int i = 0; i < 300; ++i) {
                    auto item = std::next(letters.begin(), random() % 16);
                    const Bytes bytes = cached_.get(item->first);
                    if (bytes == nullptr || *bytes != std::string(20'000, item->second)) ++wrong;
                }
            });
    }
    EXPECT_EQ(wrong, 0);
    EXPECT_LT(below_.gets, 8 * 300) << "nothing was ever kept";
}

}  // namespace
}  // namespace kiln::test
