// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "server/compute/backend.h"
#include "server/compute/replicates.h"

namespace kiln {
namespace {

/// Sums of every batch of 16 replicates of unequal size (37 or 38 points), one term, 8 places, made
/// up.
struct Sums {
    PointSet set = make_points(Sampler::random, Importance::vndf, 3, 16 * 37 + 5);
    std::vector<float> values;

    Sums() {
        for (std::size_t b = 0; b < set.batches.size(); ++b)
            for (std::size_t place = 0; place < kLanesMax; ++place)
                values.push_back(static_cast<float>(set.batches[b].point_count) *
                                 (0.5f + 0.01f * static_cast<float>((b * 7 + place * 3) % 11)));
    }
};

Replicates added(const Sums& sums, std::size_t split) {
    ThreadPool pool(2);
    Replicates replicates({{1, 0, 0}}, 1, kLanesMax);
    replicates.reset(std::vector<double>(8, 0.0));
    for (std::size_t first = 0; first < sums.set.batches.size(); first += split) {
        const std::size_t count = std::min(split, sums.set.batches.size() - first);
        replicates.add(
            pool, sums.set, first, count,
            std::span<const float>(sums.values).subspan(first * kLanesMax, count * kLanesMax));
    }
    return replicates;
}

TEST(Replicates, AnySplitOfTheBatchesGivesTheSameBits) {
    const Sums sums;
    const Replicates whole = added(sums, sums.set.batches.size());
    for (const std::size_t split : {1u, 2u, 3u, 5u, 15u}) {
        const Replicates parts = added(sums, split);
        for (std::size_t place = 0; place < 8; ++place) {
            EXPECT_EQ(whole.mean(0, place), parts.mean(0, place));
            EXPECT_EQ(whole.variance(0, place), parts.variance(0, place));
        }
    }
}

TEST(Replicates, MeanAndStandardErrorAreTheTextbookOnes) {
    const Sums sums;
    const Replicates replicates = added(sums, 4);
    for (std::size_t place = 0; place < 8; ++place) {
        double total = 0, points = 0;
        for (std::size_t b = 0; b < 16; ++b) {
            total += static_cast<double>(sums.values[b * kLanesMax + place]);
            points += sums.set.replicate_sizes[b];
        }
        const double mean = total / points;
        double spread = 0;
        for (std::size_t b = 0; b < 16; ++b) {
            const double size = sums.set.replicate_sizes[b];
            const double off =
                static_cast<double>(sums.values[b * kLanesMax + place]) / size - mean;
            spread += size * off * off;
        }
        // 16 additions of rounding 1.1e-16 each, on values near 0.5.
        EXPECT_NEAR(replicates.mean(0, place), mean, 2e-15);
        EXPECT_NEAR(std::sqrt(replicates.variance(0, place)), std::sqrt(spread / (points * 15)), 1e-13);
    }
}

TEST(Replicates, CountsWhatIsNotFinite) {
    Sums sums;
    sums.values[3 * kLanesMax + 2] = NAN;
    sums.values[5 * kLanesMax + 4] = INFINITY;
    EXPECT_EQ(added(sums, 4).non_finite(), 2u);
}

}  // namespace
}  // namespace kiln
