// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <string>
#include <vector>

#include "server/compute/points.h"
#include "server/spec/words.h"

namespace kiln {
namespace {

constexpr std::array kSamplers = {Sampler::hammersley, Sampler::sobol_owen, Sampler::lattice,
                                  Sampler::random};

TEST(Points, CosineOfATurnIsTheLibrarys) {
    for (int i = 0; i <= 100000; ++i) {
        const double u = i / 100000.0;
        // The argument 2πu of the library's cosine is itself rounded: 6.3 · 1.1e-16.
        EXPECT_NEAR(cos_turn(u), std::cos(2 * std::numbers::pi * u), 1e-15) << u;
    }
    EXPECT_EQ(cos_turn(0), 1);
    EXPECT_EQ(cos_turn(0.25), 0);
    EXPECT_EQ(cos_turn(0.5), -1);
}

/// u and cos φ of a point of visible normals: (2 √(u r) cos φ in the length of its N·h, r = 1 / (1
/// − u), …, NoV).
double u_of(const double* point) { return 1 - 1 / point[1]; }
double cosine_of(const double* point) {
    return point[0] * 0x1p23 / std::sqrt(u_of(point) * point[1]);  // N·h is 2^-24 long
}

TEST(Points, CoordinatesLieInsideTheirRanges) {
    for (const Sampler sampler : kSamplers) {
        for (const std::int64_t count : {1, 2, 15, 16, 17, 1000, 65536}) {
            const PointSet set = make_points(sampler, PointKind::visible_normals, 5, count);
            ASSERT_EQ(set.values.size(), static_cast<std::size_t>(count) * kPointScalars);
            for (std::size_t i = 0; i < set.values.size(); i += kPointScalars) {
                const double* point = &set.values[i];
                // 1 − 1 / r is off by 2^-53, 2^-20 of the least u, and the root by half of that.
                EXPECT_LE(std::abs(cosine_of(point)), 1 + 0x1p-20);
                EXPECT_GT(point[1], 1) << to_word(sampler);
                EXPECT_LE(point[1], 0x1p33) << to_word(sampler);  // half a cell from the rim
                EXPECT_GT(static_cast<float>(point[5]), 0) << to_word(sampler);
                EXPECT_LT(point[5], 1) << to_word(sampler);
            }
        }
    }
}

TEST(Points, BatchesCoverEveryPointOnceAndNoMoreThanABatchHolds) {
    for (const std::int64_t count : {1, 7, 16, 1021, 1024, 40000}) {
        const PointSet set = make_points(Sampler::random, PointKind::visible_normals, 0, count);
        std::uint32_t next = 0;
        for (const BatchRange& batch : set.batches) {
            EXPECT_EQ(batch.first_point, next);
            EXPECT_GE(batch.point_count, 1u);
            EXPECT_LE(batch.point_count, kBatchPointsMax);
            next += batch.point_count;
        }
        EXPECT_EQ(next, count);
        EXPECT_EQ(set.replicate_sizes.size(),
                  static_cast<std::size_t>(std::min<std::int64_t>(count, kReplicatesMax)));
        const auto [least, most] =
            std::minmax_element(set.replicate_sizes.begin(), set.replicate_sizes.end());
        EXPECT_LE(*most - *least, 1u);
    }
}

using Coordinate = double (*)(const double* point);

/// Of every point of one replicate.
std::vector<double> coordinates(const PointSet& set, std::size_t replicate, Coordinate of) {
    std::size_t first = 0;
    for (std::size_t r = 0; r < replicate; ++r) first += set.replicate_sizes[r];
    std::vector<double> values;
    for (std::size_t i = first; i < first + set.replicate_sizes[replicate]; ++i)
        values.push_back(of(&set.values[i * kPointScalars]));
    return values;
}

TEST(Points, AScrambledSobolSetHasOnePointInEveryInterval) {
    const PointSet set = make_points(Sampler::sobol_owen, PointKind::visible_normals, 11, 16 * 256);
    for (std::size_t r = 0; r < 16; ++r) {
        const Coordinate of_view = [](const double* point) { return point[5] * point[5]; };
        for (const Coordinate uniform : {Coordinate(u_of), of_view}) {  // NoV = √u
            std::set<int> cells;
            for (const double u : coordinates(set, r, uniform))
                cells.insert(static_cast<int>(u * 256));
            EXPECT_EQ(cells.size(), 256u) << "replicate " << r << (uniform == u_of ? "" : ", NoV");
        }
    }
}

TEST(Points, AScrambledSobolSetIsANetInTheHalfVectorsPlane) {
    // (0, 8, 2)-net in base 2: every elementary interval of area 1/256 holds one of 256 points (φ /
    // π, u).
    const PointSet set = make_points(Sampler::sobol_owen, PointKind::visible_normals, 12, 16 * 256);
    const std::vector<double> cosines = coordinates(set, 3, cosine_of),
                              us = coordinates(set, 3, u_of);
    for (int bits = 1; bits <= 7; ++bits) {
        std::vector<int> cells(256);
        const int along_u = 1 << (8 - bits), along_phi = 1 << bits;
        for (std::size_t i = 0; i < us.size(); ++i) {
            const double half_turn =
                std::acos(std::clamp(cosines[i], -1.0, 1.0)) / std::numbers::pi;
            const int column = static_cast<int>(half_turn * along_phi),
                      row = static_cast<int>(us[i] * along_u);
            ++cells[static_cast<std::size_t>(row * along_phi + column)];
        }
        for (int cell = 0; cell < along_u * along_phi; ++cell)
            EXPECT_EQ(cells[static_cast<std::size_t>(cell)], 1)
                << "split " << bits << ", cell " << cell;
    }
}

TEST(Points, EveryReplicateIsUniformAndNoTwoAreAlike) {
    for (const Sampler sampler : kSamplers) {
        const PointSet set = make_points(sampler, PointKind::visible_normals, 1, 16 * 1024);
        std::set<double> first_points;
        double mean = 0;
        for (std::size_t r = 0; r < 16; ++r) {
            const auto u = coordinates(set, r, u_of);
            first_points.insert(u.front());
            for (const double value : u) mean += value / (16.0 * 1024);
        }
        EXPECT_EQ(first_points.size(), 16u) << to_word(sampler);
        // Independent points have the largest spread: 5 standard errors of the mean of 16384
        // uniforms.
        EXPECT_NEAR(mean, 0.5, 5 * std::sqrt(1.0 / 12 / 16384)) << to_word(sampler);
    }
}

TEST(Points, AnotherSeedGivesOtherPoints) {
    for (const Sampler sampler : kSamplers)
        EXPECT_NE(make_points(sampler, PointKind::ggx_normals, 1, 64).values,
                  make_points(sampler, PointKind::ggx_normals, 2, 64).values);
}

TEST(Points, AHalfVectorOfAllNormalsComesNormalised) {
    const PointSet set = make_points(Sampler::random, PointKind::ggx_normals, 1, 4096);
    for (std::size_t i = 0; i < set.values.size(); i += kPointScalars) {
        const double x = set.values[i], z = set.values[i + 1];
        EXPECT_LE(x * x + z * z, 1 + 1e-15);  // the rest is y²
        EXPECT_NEAR(z * set.values[i + 2], 1, 1e-15);
    }
}

// Of a facet: u, and what lies to either side of a place on a line across an even disc, halved.
TEST(Points, AWalksRowHasFiveFacetsAndNoV) {
    for (const Sampler sampler : kSamplers) {
        const PointSet set = make_points(sampler, PointKind::facet_walk, 4, 16 * 256);
        ASSERT_EQ(set.values.size(), 16U * 256 * kWalkScalars);
        double sums = 0, places2 = 0, lines2 = 0;
        for (std::size_t i = 0; i < set.values.size(); i += kWalkScalars) {
            for (std::size_t facet = i; facet < i + 15; facet += 3) {
                const double u = set.values[facet];
                const double near = set.values[facet + 1], far = set.values[facet + 2];
                EXPECT_GT(u, 0);
                EXPECT_LT(u, 1);
                EXPECT_GE(near, 0);
                EXPECT_GE(far, 0);
                EXPECT_LE(near + far, 1);
                sums += u;
                places2 += (far - near) * (far - near);
                lines2 += (far + near) * (far + near);
            }
            EXPECT_GT(set.values[i + 15], 0);
            EXPECT_LT(set.values[i + 15], 1);
        }
        // Means 1/2, 1/4 and 3/4 with variances 1/12, 1/16 and 1/16: five standard errors of random
        // points.
        const double count = 5 * 16 * 256;
        EXPECT_NEAR(sums / count, .5, 5 * std::sqrt(1 / 12. / count)) << to_word(sampler);
        EXPECT_NEAR(places2 / count, .25, 5 * .25 / std::sqrt(count)) << to_word(sampler);
        EXPECT_NEAR(lines2 / count, .75, 5 * .25 / std::sqrt(count)) << to_word(sampler);
    }
}

// Facets beyond the fifth take other rows of their batch: a batch that holds a sliver of one
// dimension alone would make them repeat each other's normals.
TEST(Points, EveryBatchOfAWalkSpansTheFirstNormals) {
    for (const Sampler sampler : kSamplers) {
        const PointSet set = make_points(sampler, PointKind::facet_walk, 3, 16 * 4096);
        for (const BatchRange& batch : set.batches) {
            double least = 1, most = 0;
            for (std::size_t i = 0; i < batch.point_count; ++i) {
                const double u = set.values[kWalkScalars * (batch.first_point + i)];
                least = std::min(least, u);
                most = std::max(most, u);
            }
            // 64 random numbers all miss the last fifth in one of two million batches.
            EXPECT_LT(least, 0.2) << to_word(sampler);
            EXPECT_GT(most, 0.8) << to_word(sampler);
        }
    }
}

TEST(Points, EveryDimensionOfAWalkIsStratified) {
    const PointSet set = make_points(Sampler::sobol_owen, PointKind::facet_walk, 9, 16 * 256);
    for (std::size_t facet = 0; facet < 5; ++facet)
        for (const std::size_t dimension : {0U, 1U, 2U}) {
            std::set<int> cells;
            for (std::size_t i = 0; i < 256; ++i) {
                const double* point = &set.values[kWalkScalars * i + 3 * facet];
                // reach^2 - x^2 = 1 - v, x = sqrt(v) cos psi.
                const double v = 1 - 4 * point[1] * point[2];
                const double psi = std::acos((point[2] - point[1]) / std::sqrt(v));
                const double u = dimension == 0   ? point[0]
                                 : dimension == 1 ? psi / std::numbers::pi
                                                  : v;
                cells.insert(static_cast<int>(u * 256));
            }
            EXPECT_EQ(cells.size(), 256U) << facet << ' ' << dimension;
        }
}

}  // namespace
}  // namespace kiln
