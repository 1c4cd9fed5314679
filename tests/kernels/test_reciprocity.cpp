// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <string>

#include "server/spec/spec.h"
#include "server/spec/words.h"
#include "tests/kernels/one_lane.h"

// f(V, L) beside f(L, V), in float as tables are computed: Helmholtz reciprocity of the lobes as
// the kernels evaluate them.
namespace {

using in_float::Scattering;

constexpr int kPairs = 1000000;

struct Pair {
    float NoV, NoL, sinL, cos_phi, alpha;
};

/// Directions even over the hemisphere, alpha even over [.01, 1].
class Pairs {
  public:
    Pair operator()() {
        const float NoL = cosine_();
        return {cosine_(), NoL, sine(NoL), std::cos(azimuth_(engine_)), width_(engine_)};
    }
    static float sine(float cosine) { return std::sqrt((1 - cosine) * (1 + cosine)); }

  private:
    float cosine_() { return cosines_(engine_); }
    std::mt19937_64 engine_{17};
    std::uniform_real_distribution<float> cosines_{1e-3f, 1}, azimuth_{0, 3.14159265f},
        width_{0.01f, 1};
};

Pair swapped(Pair pair) {
    return {pair.NoL, pair.NoV, Pairs::sine(pair.NoV), pair.cos_phi, pair.alpha};
}

/// The largest |f(V, L) − f(L, V)| over the greater of the two, of all pairs.
double worst(const std::function<float(const Pair&)>& lobe) {
    Pairs pairs;
    double most = 0;
    for (int i = 0; i < kPairs; ++i) {
        const Pair pair = pairs();
        const double there = lobe(pair), back = lobe(swapped(pair));
        const double size = std::max(there, back);
        EXPECT_TRUE(std::isfinite(there) && std::isfinite(back));
        // Beckmann's and Charlie's peaks fall below the least float.
        if (size > 1e-30) most = std::max(most, std::abs(there - back) / size);
    }
    return most;
}

float specular(const Pair& pair, int distribution, int masking) {
    const Scattering s = in_float::scatter_hemisphere(KILN_IMPORTANCE_COSINE, pair.NoV,
                                                      pair.cos_phi, pair.NoL, pair.sinL);
    const float F0[8] = {0.04f, 0.96f};
    const float D = in_float::microfacet_D(distribution, pair.alpha, s.NoV, s.NoH, s.sin2_H);
    return in_float::microfacet_product(distribution, masking, pair.alpha, s, D) *
           in_float::fresnel(KILN_FRESNEL_SCHLICK, F0, s.VoH);
}

double worst_specular(int distribution, int masking) {
    return worst([=](const Pair& pair) { return specular(pair, distribution, masking); });
}

double worst_diffuse(int model) {
    return worst([=](const Pair& pair) {
        const auto d = in_float::diffuse_directions(pair.NoV, pair.NoL, pair.sinL, pair.cos_phi);
        return in_float::diffuse_lobe(model, d, pair.alpha, 0.8f);
    });
}

// Swapping the arguments changes the order of a sum or of a product: some roundings of 6e-8, not
// 1e-5.
constexpr double kReciprocal = 1e-5;

struct Named {
    const char* name;
    int distribution, masking;
};

/// Pairs of a distribution and a masking that a job may name.
std::size_t lobes_of_the_contract() {
    std::size_t count = 0;
    for (const std::string_view distribution : kiln::words<kiln::Distribution>())
        for (const std::string_view masking : kiln::words<kiln::Masking>()) {
            const std::string lobe = R"("distribution":")" + std::string(distribution) +
                                     R"(","masking":")" + std::string(masking) + "\"";
            try {
                kiln::parse_job(R"({"quantities":["directional_albedo"],"microfacet":{)" + lobe +
                                "}}");
                ++count;
            } catch (const kiln::InvalidJob&) {
            }
        }
    return count;
}

TEST(Reciprocity, EveryReciprocalSpecularLobe) {
    const Named lobes[] = {
        {"ggx smith_correlated", KILN_DISTRIBUTION_GGX, KILN_MASKING_SMITH_CORRELATED},
        {"ggx smith_separable", KILN_DISTRIBUTION_GGX, KILN_MASKING_SMITH_SEPARABLE},
        {"ggx karis_ibl", KILN_DISTRIBUTION_GGX, KILN_MASKING_KARIS_IBL},
        {"ggx karis_direct", KILN_DISTRIBUTION_GGX, KILN_MASKING_KARIS_DIRECT},
        {"ggx unreal_joint", KILN_DISTRIBUTION_GGX, KILN_MASKING_UNREAL_JOINT},
        {"beckmann smith_correlated", KILN_DISTRIBUTION_BECKMANN, KILN_MASKING_SMITH_CORRELATED},
        {"beckmann smith_separable", KILN_DISTRIBUTION_BECKMANN, KILN_MASKING_SMITH_SEPARABLE},
        {"charlie neubelt", KILN_DISTRIBUTION_CHARLIE, KILN_MASKING_NEUBELT},
        {"charlie charlie", KILN_DISTRIBUTION_CHARLIE, KILN_MASKING_CHARLIE},
    };
    ASSERT_EQ(std::size(lobes), lobes_of_the_contract());
    for (const Named& lobe : lobes) {
        const double found = worst_specular(lobe.distribution, lobe.masking);
        EXPECT_LE(found, kReciprocal) << lobe.name;
        RecordProperty(lobe.name, std::to_string(found * 1e6) + "e-6");
    }
}

TEST(Reciprocity, SoftenedCharlieIsNotReciprocal) {
    EXPECT_GT(worst_specular(KILN_DISTRIBUTION_CHARLIE, KILN_MASKING_CHARLIE_SOFTENED), 0.1);
}

TEST(Reciprocity, EveryReciprocalDiffuseLobe) {
    int held = 0;
    const auto hold = [&](int model, const char* word) {
        if (model == KILN_DIFFUSE_EON_UNREAL || model == KILN_DIFFUSE_GGX_LAMBERT) return;
        const double found = worst_diffuse(model);
        EXPECT_LE(found, kReciprocal) << word;
        RecordProperty(word, std::to_string(found * 1e6) + "e-6");
        ++held;
    };
#define KILN_TEST_ROW(number, word) hold(KILN_DIFFUSE_##number, #word);
    KILN_DIFFUSE_ROWS(KILN_TEST_ROW)
    EXPECT_GE(held, 8);
}

TEST(Reciprocity, UnrealsEonIsNotReciprocal) {
    EXPECT_GT(worst_diffuse(KILN_DIFFUSE_EON_UNREAL), 0.01);
}

}  // namespace
