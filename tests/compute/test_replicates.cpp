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
    PointSet set = make_points(Sampler::random, PointKind::visible_normals, 3, 16 * 37 + 5);
    std::vector<float> values;

    Sums() {
        for (std::size_t b = 0; b < set.batches.size(); ++b)
            for (std::size_t place = 0; place < kLanesMax; ++place)
                values.push_back(static_cast<float>(set.batches[b].point_count) *
                                 (0.5f + 0.01f * static_cast<float>((b * 7 + place * 3) % 11)));
    }
};

const std::vector<Mean> kMean = {{.terms = {1}}};
const PlaceFacts kEightPlaces = {8, {{}}, {{}}, {{}}};

TermSums<float> from(const Sums& sums, std::size_t batch) {
    TermSums<float> found;
    found.data[0] = sums.values.data() + batch * kLanesMax;
    found.step[0] = kLanesMax;
    return found;
}

Replicates added(const Sums& sums, std::size_t split) {
    ThreadPool pool(2);
    Replicates replicates(kMean);
    replicates.reset(kEightPlaces);
    for (std::size_t first = 0; first < sums.set.batches.size(); first += split) {
        const std::size_t count = std::min(split, sums.set.batches.size() - first);
        replicates.add(pool, sums.set, first, count, from(sums, first));
    }
    return replicates;
}

Estimate at(const Replicates& replicates, std::size_t place) {
    Estimate found;
    replicates.estimates(0, place, std::span(&found, 1));
    return found;
}

TEST(Replicates, AnySplitOfTheBatchesGivesTheSameBits) {
    const Sums sums;
    const Replicates whole = added(sums, sums.set.batches.size());
    for (const std::size_t split : {1u, 2u, 3u, 5u, 15u}) {
        const Replicates parts = added(sums, split);
        for (std::size_t place = 0; place < 8; ++place) {
            EXPECT_EQ(at(whole, place).value, at(parts, place).value);
            EXPECT_EQ(at(whole, place).variance, at(parts, place).variance);
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
        EXPECT_NEAR(at(replicates, place).value, mean, 2e-15);
        EXPECT_NEAR(at(replicates, place).standard_error(), std::sqrt(spread / (points * 15)),
                    1e-13);
    }
}

// The places of a level come packed; those that are not among them keep what they have.
TEST(Replicates, GrowTogetherToTheSameBits) {
    const Sums sums;
    const Replicates whole = added(sums, sums.set.batches.size());
    ThreadPool pool(2);
    GrowingReplicates growing(kMean, kEightPlaces);
    const std::vector<std::uint32_t> some = {1, 4, 6};
    growing.begin(some, true);
    Sums packed = sums;
    for (std::size_t b = 0; b < sums.set.batches.size(); ++b)
        for (std::size_t i = 0; i < some.size(); ++i)
            packed.values[b * kLanesMax + i] = sums.values[b * kLanesMax + some[i]];
    for (std::size_t b = 0; b < sums.set.batches.size(); ++b)
        growing.add(pool, sums.set, b, 1, from(packed, b));
    EXPECT_EQ(growing.estimate(0, 4).value, 0) << "nothing counts before a level is whole";
    growing.commit(pool, sums.set);
    for (const std::uint32_t place : some) {
        EXPECT_EQ(growing.estimate(0, place).value, at(whole, place).value);
        EXPECT_EQ(growing.estimate(0, place).variance, at(whole, place).variance);
        EXPECT_EQ(growing.samples(place), whole.samples());
    }
    EXPECT_EQ(growing.samples(0), 0u);
    EXPECT_EQ(growing.estimate(0, 0).value, 0);
}

TEST(Replicates, CountsWhatIsNotFinite) {
    Sums sums;
    sums.values[3 * kLanesMax + 2] = NAN;
    sums.values[5 * kLanesMax + 4] = INFINITY;
    EXPECT_EQ(added(sums, 4).non_finite(), 2u);
}

}  // namespace
}  // namespace kiln
