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
#include "server/spec/words.h"

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
    const PointSet set = make_points(Sampler::sobol_owen, point_kind(what.material), 7, 16 * 37);
    const std::vector<Scalar> points(set.values.begin(), set.values.end());
    const auto planes =
        static_cast<std::size_t>(__builtin_popcount(static_cast<unsigned>(what.material.terms)));
    std::vector<Scalar> out(set.batches.size() * planes * kStride);
    const auto parameters = any_parameters<Scalar>();
    backend.run(Launch<Scalar>{what, kStride, texels, points, parameters, set.batches, out});
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
                << to_string(set) << ", " << pool->size() << " threads, terms "
                << what.material.terms;
        }
    }
    // Where D itself is evaluated, it is infinite at roughness 0; Charlie's masking is at NoV = 0.
    const bool evaluates_D = what.material.general != 0 &&
                             (what.material.importance == 2 || what.material.importance == 3);
    for (std::size_t i = 0; i < first.size(); ++i) {
        const std::size_t texel = i % kStride;
        if (evaluates_D && (texel < 8 || texel % 8 == 0)) continue;
        EXPECT_TRUE(std::isfinite(first[i])) << "texel " << texel;
    }
}

TEST(Native, EveryInstructionSetAndThreadCountGivesTheSameBits) {
    for (const Masking masking : {Masking::smith_correlated, Masking::smith_separable})
        for (const Importance importance : {Importance::vndf, Importance::ndf})
            for (const bool averaged : {false, true})
                for (int terms = 1; terms < 8; ++terms) {
                    KernelMaterial material;
                    material.masking = static_cast<int>(masking);
                    material.importance = static_cast<int>(importance);
                    material.terms = terms;
                    material.averaged = averaged ? 1 : 0;
                    expect_equal_bits<float>({material, Precision::float32});
                    expect_equal_bits<double>({material, Precision::float64});
                }
}

TEST(Native, VisibleLightsGiveTheSameBitsToo) {
    for (const Masking masking : {Masking::smith_correlated, Masking::smith_separable})
        for (const int terms : {1, 2, 3, 3 | 7 << kColour}) {
            const KernelMaterial material{.masking = static_cast<int>(masking),
                                          .importance = kVisibleLights,
                                          .terms = terms,
                                          .fresnel = 1,
                                          .general = terms > 7 ? 1 : 0};
            expect_equal_bits<float>({material, Precision::float32});
            expect_equal_bits<double>({material, Precision::float64});
        }
}

// Under parameters without total reflection: the same operations.
TEST(Native, PartedLightsGiveTheSameBitsToo) {
    constexpr int kDielectric = 3;
    for (const int distribution : {0, 1})
        for (const int terms : {7 << kColour, 7 << kTransmitted}) {
            const KernelMaterial material{.distribution = distribution,
                                          .importance = kPartedLights,
                                          .terms = terms,
                                          .fresnel = kDielectric,
                                          .diffuse = KILN_DIFFUSE_BURLEY,
                                          .general = 1};
            expect_equal_bits<float>({material, Precision::float32});
            expect_equal_bits<double>({material, Precision::float64});
        }
}

TEST(Native, ATermIsTheSameWhateverElseIsAskedFor) {
    ThreadPool pool(1);
    const auto backend = make_native_backend(pool, usable_instruction_sets().front());
    const auto all = sums<float>(*backend, {.material = {.terms = 7}});
    for (int term = 0; term < 3; ++term) {
        const auto alone = sums<float>(*backend, {.material = {.terms = 1 << term}});
        for (std::size_t batch = 0; batch < alone.size() / kStride; ++batch)
            EXPECT_EQ(std::memcmp(&alone[batch * kStride],
                                  &all[(3 * batch + static_cast<std::size_t>(term)) * kStride],
                                  kStride * sizeof(float)),
                      0)
                << "term " << term << ", batch " << batch;
    }
}

Averages no_averages() { return {}; }

/// Every lobe, Fresnel and diffuse model of the general path, with all the terms of its pass.
std::vector<KernelMaterial> general_materials() {
    std::vector<KernelMaterial> all;
    const auto add = [&](int distribution, int masking, int importance) {
        all.push_back({.distribution = distribution,
                       .masking = masking,
                       .importance = importance,
                       .terms = 7 | 7 << kColour,
                       .fresnel = static_cast<int>(all.size() % 6),
                       .general = 1});
    };
    for (int masking = 0; masking <= 4; ++masking)
        for (int importance = 0; importance <= 3; ++importance) add(0, masking, importance);
    for (int masking = 0; masking <= 1; ++masking)
        for (int importance = 0; importance <= 3; ++importance) add(1, masking, importance);
    for (int masking = 5; masking <= 7; ++masking)
        for (int importance = 2; importance <= 3; ++importance) add(2, masking, importance);
    const int diffuse_count = static_cast<int>(words<DiffuseModel>().size()) - 1;
    // A walk is no lobe that a Fresnel term could weigh (kernels/ggx_lambert.h).
    const int simulated =
        static_cast<int>(DiffuseModel::ggx_lambert) - static_cast<int>(DiffuseModel::lambert);
    for (int diffuse = 0; diffuse < diffuse_count; ++diffuse)
        all.push_back({.importance = 2,
                       .terms = 7 << kDiffuse | (diffuse != simulated ? 7 << kTransmitted : 0),
                       .fresnel = diffuse % 6,
                       .diffuse = diffuse,
                       .general = 1});
    return all;
}

TEST(Native, EveryModelGivesTheSameBitsOnEveryInstructionSet) {
    for (KernelMaterial material : general_materials())
        for (const int averaged : {0, 1}) {
            material.averaged = averaged;
            SCOPED_TRACE("distribution " + std::to_string(material.distribution) + ", masking " +
                         std::to_string(material.masking) + ", importance " +
                         std::to_string(material.importance) + ", diffuse " +
                         std::to_string(material.diffuse) + ", averaged " +
                         std::to_string(averaged));
            expect_equal_bits<float>({material, Precision::float32});
            expect_equal_bits<double>({material, Precision::float64});
        }
}

JobSpec job(const std::string& quantities) {
    return parse_job(R"({"resolution":[8,8],"quantities":)" + quantities + "}");
}

TEST(Plan, AsksForNoTermThatNoQuantityNeeds) {
    EXPECT_EQ(
        make_plan(job(R"(["directional_albedo"])"), no_averages).passes.at(0).what.material.terms,
        1);
    EXPECT_EQ(make_plan(job(R"(["split_sum_bias"])"), no_averages).passes.at(0).what.material.terms,
              2);
    EXPECT_EQ(
        make_plan(job(R"(["split_sum_scale"])"), no_averages).passes.at(0).what.material.terms, 3);
    EXPECT_EQ(
        make_plan(job(R"(["multiscatter_albedo"])"), no_averages).passes.at(0).what.material.terms,
        4);
}

TEST(Plan, AveragesOnceARoughness) {
    const Plan plan = make_plan(job(R"(["average_albedo","split_sum_bias"])"), no_averages);
    ASSERT_EQ(plan.passes.size(), 2u);
    EXPECT_EQ(plan.passes[0].places.count(), 64u);
    EXPECT_EQ(plan.passes[0].shares.at(0).channel, 1u);
    EXPECT_EQ(plan.passes[1].places.count(), 8u);
    EXPECT_TRUE(plan.passes[1].what.material.averaged);
}

}  // namespace
}  // namespace kiln
