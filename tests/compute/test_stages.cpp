// SPDX-License-Identifier: Apache-2.0
// The stages of kernels/batch.h hand samples on; at one lane a sample goes through all of them
// before the next one starts. Both have to give the same bits for every length of a batch: shorter
// than the stages are apart, full, and with a rest.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "server/compute/native.h"
#include "tests/kernels/one_lane.h"

namespace kiln {
namespace {

constexpr std::size_t kStride = 16;
constexpr unsigned kLengths[] = {1,  2,  3,  4,  5,  7,  8,  9,  11, 12,
                                 13, 16, 63, 64, 65, 75, 76, 77, 200};

/// Sums of one term set, term by rising bit, at every texel.
std::vector<float> in_one_lane(const KernelMaterial& material, const std::vector<float>& texels,
                               const std::vector<float>& points, unsigned count) {
    const in_float::Integrand what = {material.masking, material.importance, material.terms};
    std::vector<float> sums;
    for (int term = 0; term < 3; ++term) {
        if (!(material.terms >> term & 1)) continue;
        for (std::size_t i = 0; i < kStride; ++i) {
            const auto view = in_float::ggx_view(texels[i], texels[kStride + i]);
            const in_float::Terms all =
                in_float::batch_sum(what, material.averaged, view, points.data(), count);
            sums.push_back(term == 0 ? all.weight : term == 1 ? all.fresnel : all.deficit);
        }
    }
    return sums;
}

void expect_bits_of_one_lane(const KernelMaterial& material) {
    std::vector<float> texels(2 * kStride);
    for (std::size_t i = 0; i < kStride; ++i) {
        texels[i] = static_cast<float>(i % 4) / 3 * 0.98f + 0.01f;
        texels[kStride + i] = static_cast<float>(i / 4) / 3 * 0.98f + 0.01f;
    }
    const PointSet set = make_points(Sampler::random, point_kind(material), 5, 200);
    const std::vector<float> points(set.values.begin(), set.values.end());
    const auto parameters = any_parameters<float>();
    const auto planes =
        static_cast<std::size_t>(__builtin_popcount(static_cast<unsigned>(material.terms)));
    ThreadPool pool(1);
    for (const InstructionSet isa : usable_instruction_sets())
        for (const unsigned count : kLengths) {
            const BatchRange batch[] = {{0, count}};
            std::vector<float> sums(planes * kStride);
            make_native_backend(pool, isa)->run(
                Launch<float>{{material}, kStride, texels, points, parameters, batch, sums});
            EXPECT_EQ(sums, in_one_lane(material, texels, points, count))
                << to_string(isa) << ", importance " << material.importance << ", masking "
                << material.masking << ", terms " << material.terms << ", averaged "
                << material.averaged << ", " << count << " points";
        }
}

TEST(Stages, GiveTheBitsOfOneSampleAfterTheOther) {
    struct Case {
        int importance, terms_max, averaged;
    };
    const int deficit = 1 << kDeficit;
    for (const int masking : {0, 1}) {
        for (const Case& some :
             {Case{0, 7, 0}, {0, 7, 1}, {1, 7, 0}, {1, 7, 1}, {kVisibleLights, 3, 0}})
            for (int terms = 1; terms <= some.terms_max; ++terms)
                expect_bits_of_one_lane({.masking = masking,
                                         .importance = some.importance,
                                         .terms = terms,
                                         .averaged = some.averaged});
        expect_bits_of_one_lane(
            {.masking = masking, .importance = kLogTangents, .terms = deficit, .averaged = 0});
        expect_bits_of_one_lane(
            {.masking = masking, .importance = kHorizonNormals, .terms = deficit, .averaged = 1});
    }
}

}  // namespace
}  // namespace kiln
