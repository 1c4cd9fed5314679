// SPDX-License-Identifier: Apache-2.0
// Quadrature of a large table under a loose tolerance: some texels are integrated, the others
// interpolated.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "server/compute/engine.h"
#include "server/compute/sparse_table.h"
#include "server/spec/spec.h"

namespace kiln {
namespace {

TEST(KnotLine, FindsCubicsExactlyFromEitherEnd) {
    for (const std::int64_t count : {4, 5, 17, 256, 1000})
        for (const bool flip : {false, true}) {
            const KnotLine line(count, flip, 3, 16);
            const auto& knots = line.knots();
            const auto last = static_cast<std::size_t>(count) - 1;
            ASSERT_EQ(knots.front(), 0u);
            ASSERT_EQ(knots.back(), last);
            const auto cubic = [&](std::size_t texel) {
                const double x = static_cast<double>(texel) / static_cast<double>(last);
                return 1 + x * (2 - x * (3 - 4 * x));
            };
            for (std::size_t texel = 0; texel <= last; ++texel) {
                const KnotLine::Between at = line.at(texel);
                ASSERT_LE(knots[at.cell], texel);
                ASSERT_GE(knots[at.cell + 1], texel);
                double sum = 0;
                for (std::size_t i = 0; i < 4; ++i)
                    sum += at.weight[i] * cubic(knots[at.first + i]);
                // Weights are below 2; some twenty roundings of 1e-16.
                ASSERT_NEAR(sum, cubic(texel), 1e-14) << count << " " << texel;
            }
            // A part of a row, from each texel to each other.
            std::vector<double> of_knots, row(last + 1);
            for (const std::size_t knot : knots) of_knots.push_back(cubic(knot));
            for (std::size_t begin = 0; begin <= last; begin += 1 + last / 20)
                for (std::size_t end = begin + 1; end <= last + 1; end += 1 + last / 20) {
                    line.interpolate(of_knots.data(), begin, end, row.data());
                    for (std::size_t texel = begin; texel < end; ++texel)
                        ASSERT_NEAR(row[texel - begin], cubic(texel), 1e-14)
                            << count << " " << begin << " " << texel;
                }
        }
}

// As of a lattice: quarters between two texels, then a gap of 0, 1, 2 and on.
TEST(KnotLine, FindsCubicsExactlyBesideGaps) {
    std::vector<double> positions;
    for (int texel = 0, gap = 0; positions.size() < 200; texel += 2 + gap++)
        for (int part = 0; part <= 4; ++part) positions.push_back(texel + part / 4.0);
    for (const bool flip : {false, true}) {
        const KnotLine line(200, flip, 6, 8, positions);
        const auto cubic = [&](std::size_t place) {
            const double x = positions[place] / positions.back();
            return 1 + x * (2 - x * (3 - 4 * x));
        };
        for (std::size_t place = 0; place < positions.size(); ++place) {
            const KnotLine::Between at = line.at(place);
            double sum = 0;
            for (std::size_t i = 0; i < 4; ++i)
                sum += at.weight[i] * cubic(line.knots()[at.first + i]);
            // As above: sums of four weights are below 2, a cubic is up to 3.
            ASSERT_NEAR(sum, cubic(place), 1e-14) << place << " " << flip;
        }
        // The judge of a cell is the place that is furthest from both of its ends.
        for (std::size_t cell = 0; cell < line.cells(); ++cell) {
            const std::size_t low = line.knots()[cell], high = line.knots()[cell + 1];
            const auto far = [&](std::size_t place) {
                return (positions[place] - positions[low]) * (positions[high] - positions[place]);
            };
            for (std::size_t place = low; place <= high; ++place)
                ASSERT_GE(far(line.middle(cell)), far(place)) << cell << " " << place;
        }
    }
}

Outcome bake(const std::string& fields) {
    return Engine({}).run(parse_job(R"({"device":"native","integrator":"quadrature",)"
                                    R"("output":{"pixel":"float"},)" +
                                    fields + "}"),
                          Control{});
}

const LeftOut* interpolation_of(const Report& report) {
    const auto at =
        std::find_if(report.left_out.begin(), report.left_out.end(),
                     [](const LeftOut& entry) { return entry.what.find("quadrature at") == 0; });
    return at == report.left_out.end() ? nullptr : &*at;
}

// Against every texel in double, which takes no part in this.
TEST(SparseTable, IsWithinTheToleranceEverywhere) {
    for (const char* table :
         {R"("quantities":["split_sum_scale","split_sum_bias"],"resolution":[256,192])",
          R"("quantities":["directional_albedo"],"resolution":[128,128],"layout":"unity")",
          R"("quantities":["split_sum_scale","split_sum_bias"],"resolution":[96,160],)"
          R"("layout":{"x":{"parameter":"roughness","flip":true},"y":{"parameter":"NoV",)"
          R"("mapping":"sqrt","grid":"node"}})",
          R"("quantities":["specular_albedo"],"resolution":[128,128],)"
          R"("fresnel":{"model":"dielectric","ior":1.01})",
          R"("quantities":["specular_albedo"],"resolution":[128,128],)"
          R"("fresnel":{"model":"conductor","metal":"copper"})",
          // 1 - E of a lobe that has no rule for it.
          R"("quantities":["multiscatter_albedo"],"resolution":[128,128],)"
          R"("microfacet":{"distribution":"ggx","masking":"karis_ibl"})"}) {
        const std::string job = table;
        const Outcome exact = bake(job + R"(,"precision":"float64")");
        EXPECT_EQ(interpolation_of(exact.report), nullptr);
        for (const double tolerance : {1.3e-2, 1e-3, 1e-4, 1e-5}) {
            const Outcome sparse = bake(job + R"(,"target_error":)" + std::to_string(tolerance));
            ASSERT_NE(interpolation_of(sparse.report), nullptr) << job;
            EXPECT_EQ(sparse.report.status, "converged") << job;
            for (std::size_t c = 0; c < exact.table.planes.size(); ++c) {
                double most = 0;
                for (std::size_t i = 0; i < exact.table.planes[c].size(); ++i)
                    most = std::max<double>(
                        most, std::abs(exact.table.planes[c][i] - sparse.table.planes[c][i]));
                EXPECT_LE(most, tolerance + 1e-6) << job << " " << tolerance;
                const auto& error = sparse.report.error[c].reference_max;
                ASSERT_TRUE(error.has_value());
                EXPECT_LE(most, 2 * *error + 1e-6) << job << " " << tolerance;
            }
        }
    }
}

TEST(SparseTable, PaysForAFewTexelsUnderALooseTolerance) {
    const std::string job =
        R"("quantities":["split_sum_scale","split_sum_bias"],"resolution":[256,256])";
    const auto cost = [&](const char* tolerance) {
        return bake(job + R"(,"target_error":)" + tolerance).report.work.brdf_evaluations;
    };
    // Two orders, 40 and 75 nodes, at every texel would be 7.5 million.
    EXPECT_LT(cost("1.3e-2"), 750000u);
    EXPECT_LT(cost("1e-2"), cost("1e-4"));
}

// 1 - E spans decades, and its tolerance is relative.
TEST(SparseTable, LeavesDeficitsAlone) {
    const Outcome outcome =
        bake(R"("quantities":["multiscatter_albedo"],"resolution":[128,128],"target_error":1e-2)");
    EXPECT_EQ(interpolation_of(outcome.report), nullptr);
}

}  // namespace
}  // namespace kiln
