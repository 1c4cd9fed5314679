// SPDX-License-Identifier: Apache-2.0
#include "client/compare.h"

#include <gtest/gtest.h>

#include <limits>

namespace kiln::client {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

Table table(std::vector<std::string> channels, std::vector<std::vector<float>> planes) {
    return {.width = 2, .height = 2, .channels = std::move(channels), .planes = std::move(planes)};
}

TEST(Compare, channels_are_matched_by_name_not_by_order) {
    const Table a = table({"A", "B"}, {{1, 2, 3, 4}, {5, 6, 7, 8}});
    const Table b = table({"B", "A"}, {{5, 6, 7, 8}, {1, 2, 3, 5}});
    const Comparison result = compare(a, b);
    ASSERT_EQ(result.channels.size(), 2u);
    EXPECT_EQ(result.channels[0].max, 1);
    EXPECT_EQ(result.channels[0].x, 1u);
    EXPECT_EQ(result.channels[0].y, 1u);
    EXPECT_EQ(result.channels[1].max, 0);
    EXPECT_TRUE(result.within(1));
    EXPECT_FALSE(result.within(0.5));
}

TEST(Compare, a_table_of_nan_is_not_itself) {
    const Table a = table({"A"}, {{kNan, kNan, kNan, kNan}});
    const Comparison result = compare(a, a);
    EXPECT_EQ(result.channels[0].incomparable_count, 4u);
    EXPECT_EQ(result.channels[0].rms, 0);
    EXPECT_FALSE(result.within(std::numeric_limits<double>::infinity()));
}

TEST(Compare, a_mismatch_is_never_within) {
    const Table a = table({"A"}, {{1, 2, 3, 4}});
    const Comparison names = compare(a, table({"B"}, {{1, 2, 3, 4}}));
    EXPECT_FALSE(names.mismatch.empty());
    EXPECT_FALSE(names.within(1e9));
    Table flat = a;
    flat.width = 4;
    flat.height = 1;
    EXPECT_FALSE(compare(a, flat).within(1e9));
}

// Differences are taken in double: in float these would overflow to infinity.
TEST(Compare, the_largest_floats_can_be_told_apart) {
    const float huge = std::numeric_limits<float>::max();
    const Comparison result =
        compare(table({"A"}, {{huge, 0, 0, 0}}), table({"A"}, {{-huge, 0, 0, 0}}));
    EXPECT_EQ(result.channels[0].max, 2 * static_cast<double>(huge));
    EXPECT_EQ(result.channels[0].incomparable_count, 0u);
}

}  // namespace
}  // namespace kiln::client
