// SPDX-License-Identifier: Apache-2.0
#include "server/store/measurement_store.h"

#include "server/base/sha256.h"
#include "tests/store/support.h"

namespace kiln::test {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kFile = 100;

class MeasurementStoreTest : public testing::Test {
  protected:
    static std::set<std::string> nobody() { return {}; }

    std::string keep(MeasurementStore& store, const std::string& bytes,
                     const std::function<std::set<std::string>()>& in_use = nobody) const {
        const auto blob = store.receive();
        for (const char byte : bytes) blob->write(std::string_view(&byte, 1));
        Measurement what;
        what.format = "csv";
        what.account = "{}";
        return store.keep(*blob, what, in_use).digest;
    }
    std::string entry(const std::string& digest) const {
        return folder_ / ("measurements/cas.v1/" + digest.substr(0, 2) + "/" + digest);
    }
    std::size_t files() const {
        std::size_t count = 0;
        for (const auto& item : fs::recursive_directory_iterator(folder_ / "measurements/cas.v1"))
            count += item.is_regular_file();
        return count;
    }
    TemporaryFolder folder_;
};

TEST_F(MeasurementStoreTest, BytesInPiecesAreFoundUnderTheirHash) {
    const std::string bytes(kFile, 'a');
    {
        MeasurementStore store(folder_.path(), 1 << 20);
        EXPECT_EQ(keep(store, bytes), sha256_hex(bytes));
        EXPECT_EQ(store.find(sha256_hex(bytes))->bytes, kFile);
    }
    MeasurementStore store(folder_.path(), 1 << 20);
    EXPECT_EQ(store.find_sound(sha256_hex(bytes))->format, "csv");
    EXPECT_EQ(measurement_bytes(folder_.path(), sha256_hex(bytes)), bytes);
    EXPECT_FALSE(store.find(sha256_hex("b")));
    EXPECT_EQ(error_of([&] { measurement_bytes(folder_.path(), sha256_hex("b")); })[0],
              "measurement_missing");
}

TEST_F(MeasurementStoreTest, WhatIsNotKeptLeavesNothing) {
    MeasurementStore store(folder_.path(), 1 << 20);
    {
        const auto blob = store.receive();
        blob->write("half of it");
        EXPECT_EQ(files(), 1u);
    }
    EXPECT_EQ(files(), 0u);
}

TEST_F(MeasurementStoreTest, TheLeastRecentlyUsedGoAndThoseInUseStay) {
    MeasurementStore store(folder_.path(), 3 * (kFile + 2));
    std::vector<std::string> digests;
    for (const char c : {'a', 'b', 'c'}) digests.push_back(keep(store, std::string(kFile, c)));
    store.find(digests[0]);  // now b is the oldest, then c
    const std::string d =
        keep(store, std::string(kFile, 'd'), [&] { return std::set{digests[1]}; });
    EXPECT_TRUE(store.find(digests[0]));
    EXPECT_TRUE(store.find(digests[1]));
    EXPECT_FALSE(store.find(digests[2]));
    EXPECT_FALSE(fs::exists(entry(digests[2])));
    EXPECT_EQ(error_of([&] {
                  keep(store, std::string(kFile, 'e'), [&] {
                      return std::set{digests[0], digests[1], d};
                  });
              })[0],
              "measurements_full");
    EXPECT_EQ(files(), 3u);
}

TEST_F(MeasurementStoreTest, DamageCountsAsAbsentAndIsRepaired) {
    MeasurementStore store(folder_.path(), 1 << 20);
    const std::string bytes(kFile, 'a'), digest = keep(store, bytes);
    std::ofstream(entry(digest)) << std::string(kFile, 'x');
    EXPECT_EQ(error_of([&] { measurement_bytes(folder_.path(), digest); })[0],
              "measurement_missing");
    EXPECT_FALSE(store.find_sound(digest));
    EXPECT_EQ(keep(store, bytes), digest);
    EXPECT_EQ(measurement_bytes(folder_.path(), digest), bytes);
    EXPECT_EQ(store.list(10, "").measurements.size(), 1u);
}

TEST_F(MeasurementStoreTest, StraysOfACrashAreForgotten) {
    const std::string digest = [&] {
        MeasurementStore store(folder_.path(), 1 << 20);
        keep(store, "b");
        return keep(store, "a");
    }();
    fs::remove(entry(digest));
    std::ofstream(entry(sha256_hex("stray"))) << "stray";
    MeasurementStore store(folder_.path(), 1 << 20);
    EXPECT_EQ(store.list(10, "").measurements.size(), 1u);
    EXPECT_EQ(files(), 1u);
}

TEST_F(MeasurementStoreTest, PagesAreNewestFirst) {
    MeasurementStore store(folder_.path(), 1 << 20);
    std::vector<std::string> digests;
    for (const char* bytes : {"a", "b", "c"}) digests.push_back(keep(store, bytes));
    const MeasurementPage first = store.list(2, "");
    ASSERT_EQ(first.measurements.size(), 2u);
    EXPECT_EQ(first.measurements[0].digest, digests[2]);
    const MeasurementPage last = store.list(2, first.next_cursor);
    ASSERT_EQ(last.measurements.size(), 1u);
    EXPECT_EQ(last.measurements[0].digest, digests[0]);
    EXPECT_EQ(last.next_cursor, "");
    for (const char* wrong : {"x", "0", "-1", "01", "1 "})
        EXPECT_EQ(error_of([&] { store.list(2, wrong); })[0], "bad_cursor") << wrong;
}

}  // namespace
}  // namespace kiln::test
