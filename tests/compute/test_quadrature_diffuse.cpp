// SPDX-License-Identifier: Apache-2.0
// Quadrature of diffuse lobes, beside quadrature over (NoL, phi) that shares no line with it.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "server/base/error.h"
#include "server/compute/engine.h"
#include "server/compute/native.h"
#include "server/compute/quadrature.h"
#include "server/spec/spec.h"
#include "server/spec/words.h"
#include "tests/reference/diffuse_models.h"

namespace kiln {
namespace {

constexpr double kAlbedo = 0.8;
constexpr double kF0 = 0.04;

/// All that have a lobe, analytic between the folds that the rule knows.
std::vector<DiffuseModel> models() {
    std::vector<DiffuseModel> models;
    for (std::size_t i = 0; i < words<DiffuseModel>().size(); ++i) {
        const auto model = static_cast<DiffuseModel>(i);
        if (model != DiffuseModel::none && model != DiffuseModel::chan2018 &&
            model != DiffuseModel::ggx_lambert)
            models.push_back(model);
    }
    return models;
}

reference::Diffuse truth(DiffuseModel model, double roughness) {
    return {reference::diffuse_model(to_word(model)), roughness, kAlbedo};
}

/// 1 - F of Schlick's 0.04.
const reference::DiffuseWeight kTransmitted = {[](double, double VoH) {
                                                   const double m = 1 - VoH;
                                                   return (1 - kF0) * (1 - m * m * m * m * m);
                                               },
                                               {},
                                               {}};

// Both sides promise 1e-9.
TEST(QuadratureOfDiffuse, IsThatOfTheReferenceInDouble) {
    ThreadPool pool(1);
    const auto backend = make_native_backend(pool, usable_instruction_sets().front());
    std::vector<double> NoV, alpha;
    for (const double cosine : {1e-4, 1e-3, 0.02, 0.3, 0.7, 0.999, 1.0})
        for (const double roughness : {0.01, 0.5, 1.0}) {
            NoV.push_back(cosine);
            alpha.push_back(roughness * roughness);
        }
    for (const DiffuseModel model : models())
        for (const int fresnel : {kNoFresnel, kSchlickWeight}) {
            const QuadratureKind kind{
                DiffuseRule{static_cast<int>(model) - static_cast<int>(DiffuseModel::lambert),
                            fresnel},
                Precision::float64};
            QuadratureParameters parameters{kF0, 1 - kF0};
            parameters.back() = kAlbedo;
            const QuadratureResult found =
                integrate_quadrature(*backend, kind, {NoV, alpha, parameters, {}}, {1e-10, 0});
            EXPECT_TRUE(found.converged()) << to_word(model);
            for (std::size_t i = 0; i < NoV.size(); ++i) {
                const reference::Diffuse lobe = truth(model, std::sqrt(alpha[i]));
                const double wanted = fresnel == kNoFresnel
                                          ? reference::diffuse_albedo(lobe, NoV[i])
                                          : reference::diffuse_integral(lobe, NoV[i], kTransmitted);
                EXPECT_NEAR(found.E[i], wanted, 2e-9)
                    << to_word(model) << " under " << fresnel << ", NoV " << NoV[i] << ", alpha "
                    << alpha[i] << ", order " << kQuadratureSteps[found.step[i]].order.elevation;
            }
        }
}

// One over these cosines is infinite in float: the Oren-Nayar family had no value there.
TEST(QuadratureOfDiffuse, FloatHoldsAtViewsAlongTheSurface) {
    ThreadPool pool(1);
    const auto backend = make_native_backend(pool, usable_instruction_sets().front());
    std::vector<double> NoV, alpha;
    for (const float cosine : {3e-45f, 6e-42f, 2e-39f, 1e-37f, 1e-20f})
        for (const float width : {1e-4f, 0.25f, 1.0f}) {
            NoV.push_back(cosine);
            alpha.push_back(width);
        }
    QuadratureParameters parameters{};
    parameters.back() = kAlbedo;
    for (const DiffuseModel model : models()) {
        const DiffuseRule rule{static_cast<int>(model) - static_cast<int>(DiffuseModel::lambert)};
        const auto albedo = [&](Precision precision, double tolerance) {
            return integrate_quadrature(*backend, {rule, precision}, {NoV, alpha, parameters, {}},
                                        {tolerance, 0})
                .E;
        };
        const auto narrow = albedo(Precision::float32, 1e-6);
        const auto wide = albedo(Precision::float64, 1e-9);
        for (std::size_t i = 0; i < NoV.size(); ++i)
            EXPECT_NEAR(narrow[i], wide[i], 1.5e-6)
                << to_word(model) << ", NoV " << NoV[i] << ", alpha " << alpha[i];
    }
}

struct Baked {
    JobSpec job;
    Outcome outcome;
};

Baked bake(const std::string& rest) {
    Baked baked;
    baked.job = parse_job(R"({"integrator":"quadrature","device":"native","resolution":[3,2],)" +
                          rest + "}");
    baked.outcome = Engine({}).run(baked.job, Control{});
    return baked;
}

// In float: the albedo, its average and a coupled material, three colours of which one is kAlbedo.
TEST(QuadratureOfDiffuse, MakesWholeJobs) {
    for (const DiffuseModel model : models()) {
        const std::string word(to_word(model));
        const Baked baked = bake(R"("quantities":["diffuse_albedo","diffuse_average_albedo"],)"
                                 R"("diffuse":{"model":")" +
                                 word + R"(","albedo":[0.1,0.8,1]})");
        const auto& planes = baked.outcome.table.planes;
        ASSERT_EQ(planes.size(), 6u);
        EXPECT_EQ(baked.outcome.report.status, "converged") << word;
        EXPECT_EQ(baked.outcome.report.work.fresnel_evaluations, 0u);
        for (std::size_t i = 0; i < 6; ++i) {
            const double cosine = (static_cast<double>(i % 3) + 0.5) / 3;
            const reference::Diffuse lobe = truth(model, (static_cast<double>(i / 3) + 0.5) / 2);
            EXPECT_NEAR(planes[1][i], reference::diffuse_albedo(lobe, cosine), 1e-6) << word;
            if (i % 3 == 0) {
                EXPECT_NEAR(planes[4][i], reference::diffuse_average(lobe), 1e-6) << word;
            } else {
                EXPECT_EQ(planes[4][i], planes[4][i - 1]) << word;
            }
        }
    }
}

// What a coupled material's diffuse lobe adds, beside the specular lobe alone.
TEST(QuadratureOfDiffuse, StandsUnderTheFresnelTermOfItsCoupling) {
    const std::string rest = R"("quantities":["total_albedo"],"fresnel":{"f0":0.04},)"
                             R"("coupling":"half_vector","diffuse":{"model":)";
    const Baked both = bake(rest + R"("eon","albedo":0.8})"), bare = bake(rest + R"("none"})");
    EXPECT_GT(both.outcome.report.work.fresnel_evaluations,
              bare.outcome.report.work.fresnel_evaluations);
    for (std::size_t i = 0; i < 6; ++i) {
        const double cosine = (static_cast<double>(i % 3) + 0.5) / 3;
        const reference::Diffuse lobe =
            truth(DiffuseModel::eon, (static_cast<double>(i / 3) + 0.5) / 2);
        const double added = static_cast<double>(both.outcome.table.planes[0][i]) -
                             static_cast<double>(bare.outcome.table.planes[0][i]);
        EXPECT_NEAR(added, reference::diffuse_integral(lobe, cosine, kTransmitted), 2e-6) << i;
    }
}

// A fold along a curve: refused, where a report would say "converged" of a guess.
TEST(QuadratureOfDiffuse, RefusesALobeWithoutASmoothForm) {
    try {
        parse_job(R"({"integrator":"quadrature","quantities":["diffuse_albedo"],)"
                  R"("resolution":[4,4],"diffuse":{"model":"chan2018"}})");
        FAIL();
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("chan2018"), std::string::npos) << error.what();
    }
}

}  // namespace
}  // namespace kiln
