// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "server/compute/table.h"

namespace kiln::client {

/// Of the finite texels of one channel; `nan_count` and `infinite_count` tell of the others.
struct ChannelStatistics {
    std::string name;
    double min = 0, max = 0, mean = 0;
    std::uint64_t finite_count = 0, nan_count = 0, infinite_count = 0;
};
std::vector<ChannelStatistics> statistics_of(const Table& table);

/// One channel of a table against the same channel of another.
struct ChannelDifference {
    std::string name;
    double max = 0;            ///< largest |a − b| among texels where it is finite
    double rms = 0;            ///< over the same texels
    std::size_t x = 0, y = 0;  ///< texel of the largest difference; the first non-finite one if any
    double a = 0, b = 0;       ///< values there
    std::uint64_t incomparable_count =
        0;  ///< texels with a NaN, or with infinities that are not equal
};

struct Comparison {
    std::string mismatch;  ///< why the two cannot be compared texel by texel; "" where they can
    std::vector<ChannelDifference> channels;
    /// NaN is never within any bound, nor is a mismatch.
    bool within(double max_error) const;
};
Comparison compare(const Table& a, const Table& b);

}  // namespace kiln::client
