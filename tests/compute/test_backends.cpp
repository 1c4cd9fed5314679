// SPDX-License-Identifier: Apache-2.0
// Equal bits from every instruction set, thread count and precision's lane width.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "server/compute/native.h"
#include "server/compute/plan.h"
#include "server/spec/spec.h"

namespace kiln {
namespace {

constexpr std::size_t kStride = 64;

/// Sums of one launch over an 8 × 8 grid of (NoV, roughness) that includes the ends of both.
template <typename Scalar>
std::vector<Scalar> sums(Backend& backend, Specialisation what) {
    std::vector<Scalar> texels(2 * kStride);
    for (std::size_t i = 0; i < kStride; ++i) {
        texels[i] = static_cast<Scalar>(static_cast<double>(i % 8) / 7);
        const double roughness = static_cast<double>(i / 8) / 7;
        texels[kStride + i] = static_cast<Scalar>(roughness * roughness);
    }
    const PointSet set = make_points(Sampler::sobol_owen, what.importance, 7, 16 * 37);
    const std::vector<Scalar> points(set.values.begin(), set.values.end());
    const auto planes =
        static_cast<std::size_t>(__builtin_popcount(static_cast<unsigned>(what.terms)));
    std::vector<Scalar> out(set.batches.size() * planes * kStride);
    backend.run(Launch<Scalar>{what, kStride, texels, points, set.batches, out});
    return out;
}

template <typename Scalar>
void expect_equal_bits(const Specialisation& what) {
    ThreadPool one(1), three(3);
    const auto sets = usable_instruction_sets();
    const auto first = sums<Scalar>(*make_native_backend(one, sets.front()), what);
    for (const InstructionSet set : sets) {
        for (ThreadPool* pool : {&one, &three}) {
            const auto other = sums<Scalar>(*make_native_backend(*pool, set), what);
            EXPECT_EQ(std::memcmp(first.data(), other.data(), first.size() * sizeof(Scalar)), 0)
                << to_string(set) << ", " << pool->size() << " threads, terms " << what.terms;
        }
    }
    for (const Scalar sum : first) EXPECT_TRUE(std::isfinite(sum));
}

TEST(Native, EveryInstructionSetAndThreadCountGivesTheSameBits) {
    for (const Masking masking : {Masking::smith_correlated, Masking::smith_separable})
        for (const Importance importance : {Importance::vndf, Importance::ndf})
            for (const bool averaged : {false, true})
                for (int terms = 1; terms < 8; ++terms) {
                    expect_equal_bits<float>(
                        {masking, importance, terms, averaged, Precision::float32});
                    expect_equal_bits<double>(
                        {masking, importance, terms, averaged, Precision::float64});
                }
}

TEST(Native, ATermIsTheSameWhateverElseIsAskedFor) {
    ThreadPool pool(1);
    const auto backend = make_native_backend(pool, usable_instruction_sets().front());
    const auto all = sums<float>(*backend, {.terms = 7});
    for (int term = 0; term < 3; ++term) {
        const auto alone = sums<float>(*backend, {.terms = 1 << term});
        for (std::size_t batch = 0; batch < alone.size() / kStride; ++batch)
            EXPECT_EQ(std::memcmp(&alone[batch * kStride],
                                  &all[(3 * batch + static_cast<std::size_t>(term)) * kStride],
                                  kStride * sizeof(float)),
                      0)
                << "term " << term << ", batch " << batch;
    }
}

JobSpec job(const std::string& quantities) {
    return parse_job(R"({"resolution":[8,8],"quantities":)" + quantities + "}");
}

TEST(Plan, AsksForNoTermThatNoQuantityNeeds) {
    EXPECT_EQ(make_plan(job(R"(["directional_albedo"])")).passes.at(0).what.terms, 1);
    EXPECT_EQ(make_plan(job(R"(["split_sum_bias"])")).passes.at(0).what.terms, 2);
    EXPECT_EQ(make_plan(job(R"(["split_sum_scale"])")).passes.at(0).what.terms, 3);
    EXPECT_EQ(make_plan(job(R"(["multiscatter_albedo"])")).passes.at(0).what.terms, 4);
}

TEST(Plan, AveragesOnceARoughness) {
    const Plan plan = make_plan(job(R"(["average_albedo","split_sum_bias"])"));
    ASSERT_EQ(plan.passes.size(), 2u);
    EXPECT_EQ(plan.passes[0].places.count(), 64u);
    EXPECT_EQ(plan.passes[0].channels, std::vector<std::size_t>{1});
    EXPECT_EQ(plan.passes[1].places.count(), 8u);
    EXPECT_TRUE(plan.passes[1].what.averaged);
}

}  // namespace
}  // namespace kiln
