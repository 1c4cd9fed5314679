// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <numbers>
#include <random>

#include "server/study/facet_walks.h"
#include "tests/reference/ggx_lambert.h"
#include "tests/study/studying.h"

// f(V, L) of ggx_lambert as a mean over walks, beside quadrature of its first bounce, the albedo by
// invariance, and itself with V and L exchanged.
namespace kiln {
namespace {

using namespace studying;

// A nearly black surface sends light on once: the second bounce is a thousandth of the first.
TEST(FacetWalks, OneBounceIsTheQuadratures) {
    constexpr double kAlbedo = 1e-3;
    for (const double alpha : {0.1, 0.5, 1.0})
        for (const Directions d :
             {Directions{0.8, 0.6, -0.5}, {0.3, 0.9, 0.2}, {0.2, 0.4, 1}, {0.5, 0.2, -1}}) {
            const WalkedValue found = FacetWalks(alpha, kAlbedo, 3).value(d, 1 << 14);
            const double truth =
                kAlbedo * reference::ggx_lambert_single(alpha, d.NoV, d.NoL, d.cos_phi);
            EXPECT_GT(found.standard_error, 0);
            EXPECT_LT(found.standard_error, 0.03 * truth);
            EXPECT_NEAR(found.value, truth, 5 * found.standard_error + 1e-3 * truth)
                << "alpha " << alpha << ", NoV " << d.NoV << ", NoL " << d.NoL;
        }
}

// The mean of π f over cosine-distributed lights is the albedo, all bounces together.
TEST(FacetWalks, SummedOverTheHemisphereTheyAreTheAlbedo) {
    constexpr int kLights = 1 << 15;
    std::mt19937_64 engine(5);
    std::uniform_real_distribution<double> uniform(1e-6, 1);
    for (const double alpha : {0.3, 0.9})
        for (const double NoV : {0.2, 0.8}) {
            FacetWalks walks(alpha, 0.8, 7);
            double sum = 0, squares = 0;
            for (int i = 0; i < kLights; ++i) {
                const double cos_phi = std::cos(std::numbers::pi * uniform(engine));
                const double value =
                    std::numbers::pi *
                    walks.value({NoV, std::sqrt(uniform(engine)), cos_phi}, 2).value;
                sum += value;
                squares += value * value;
            }
            const double mean = sum / kLights;
            const double error = std::sqrt((squares / kLights - mean * mean) / kLights);
            const double truth = reference::ggx_lambert_albedo(
                reference::ggx_lambert_shares(alpha, {NoV}, 40)[0], 0.8);
            EXPECT_LT(error, 0.01);
            EXPECT_NEAR(mean, truth, 5 * error) << "alpha " << alpha << ", NoV " << NoV;
        }
}

TEST(FacetWalks, ABlackSurfaceSendsNothing) {
    const WalkedValue found = FacetWalks(0.5, 0, 1).value({0.5, 0.5, 0}, 16);
    EXPECT_EQ(found.value, 0);
    EXPECT_EQ(found.standard_error, 0);
}

const std::string kBare = R"("fresnel":{"model":"schlick","f0":0,"f90":0},"coupling":"view",)";

TEST(FacetWalks, TheFurnaceOfTheFacetsAlone) {
    const Study white =
        study_of(R"({"kind":"furnace",)" + kBare + R"("diffuse":{"model":"ggx_lambert"}})").study;
    for (const char* name : {"positivity", "energy conservation", "reciprocity", "nothing is lost"})
        EXPECT_TRUE(verdict(white, name).holds) << name << ": " << verdict(white, name).words;
    EXPECT_GT(verdict(white, "positivity").value.value(), 0);
    const Study grey = study_of(R"({"kind":"furnace",)" + kBare +
                                R"("diffuse":{"model":"ggx_lambert","albedo":0.5}})")
                           .study;
    EXPECT_TRUE(verdict(grey, "reciprocity").holds);
    EXPECT_FALSE(verdict(grey, "nothing is lost").holds);
}

// What is not reciprocal is found through the walks' noise: F of the view alone.
TEST(FacetWalks, UnderAViewsFresnelTheyAreNotReciprocal) {
    const Study study = study_of(R"({"kind":"furnace","coupling":"view",)"
                                 R"("diffuse":{"model":"ggx_lambert","albedo":0.8}})")
                            .study;
    EXPECT_FALSE(verdict(study, "reciprocity").holds);
    EXPECT_FALSE(verdict(study, "reciprocity").expected);
    EXPECT_TRUE(verdict(study, "energy conservation").holds);
    EXPECT_TRUE(verdict(study, "positivity").holds);
}

}  // namespace
}  // namespace kiln
