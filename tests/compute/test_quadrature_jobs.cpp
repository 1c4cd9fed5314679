// SPDX-License-Identifier: Apache-2.0
// Whole jobs with "integrator": "quadrature", on both backends.
#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <string>

#include "server/base/error.h"
#include "server/compute/opencl.h"
#include "server/spec/spec.h"
#include "tests/reference/microfacet_albedo.h"
#include "tests/reference/reference.h"

namespace kiln {
namespace {

struct Baked {
    Outcome outcome;
    JobSpec job;
};

Baked bake(const std::string& rest, const std::string& device = "native",
           EngineOptions options = {}) {
    Baked baked;
    const std::string wide = rest.starts_with(R"("precision")") ? "" : R"("precision":"float64",)";
    baked.job =
        parse_job(R"({"integrator":"quadrature","device":")" + device + "\"," + wide + rest + "}");
    baked.outcome = Engine(std::move(options)).run(baked.job, Control{});
    return baked;
}

/// One texel at a place: axes whose only node is there.
std::string at(double NoV, double alpha) {
    const auto axis = [](const char* parameter, double value) {
        return std::string(R"({"parameter":")") + parameter + R"(","grid":"node","range":[)" +
               std::to_string(value) + "," + std::to_string(value + 1e-3) + "]}";
    };
    return R"("resolution":[1,1],"layout":{"x":)" + axis("NoV", NoV) + R"(,"y":)" +
           axis("alpha", alpha) + "}";
}

bool opencl_is_here() {
    for (const DeviceInfo& device : opencl_devices())
        if (device.usable) return true;
    return false;
}

struct Spot {
    const char* fresnel;
    double NoV, alpha, albedo;
};

// Computed once by another program (tanh-sinh in double), to 13 digits; correlated masking.
const Spot kSpots[] = {
    {R"({"model":"dielectric","ior":1.5})", 0.1, 0.01, 0.5606928591947141},
    {R"({"model":"dielectric","ior":1.5})", 0.5, 0.25, 0.06689850709319349},
    {R"({"model":"dielectric","ior":1.5})", 0.1, 0.25, 0.1718396987451538},
    {R"({"model":"conductor","eta":0.18,"k":3.4})", 0.1, 0.01, 0.9583963854881774},
    {R"({"model":"conductor","eta":0.18,"k":3.4})", 0.5, 0.25, 0.8063285627056721},
    {R"({"model":"conductor","eta":0.18,"k":3.4})", 0.1, 0.25, 0.8404943404865305},
};

class QuadratureJobs : public testing::TestWithParam<const char*> {
  protected:
    void SetUp() override {
        if (std::string(GetParam()) == "opencl" && !opencl_is_here())
            GTEST_SKIP() << "no OpenCL device on this machine";
    }
};

TEST_P(QuadratureJobs, MeetPublishedFresnelAlbedos) {
    for (const Spot& spot : kSpots) {
        const Baked baked = bake(R"("quantities":["specular_albedo"],"fresnel":)" +
                                     std::string(spot.fresnel) + "," + at(spot.NoV, spot.alpha),
                                 GetParam());
        // A plane is float: half a unit in the last place of 1, beside 1e-9.
        EXPECT_NEAR(baked.outcome.table.planes[0][0], spot.albedo, 6.1e-8) << spot.fresnel;
        EXPECT_EQ(baked.outcome.report.status, "converged");
        EXPECT_EQ(baked.outcome.report.device.backend, GetParam());
        EXPECT_FALSE(baked.outcome.report.device.fallback);
    }
}

// Total reflection has a rule of its own, which test_quadrature_lobes.cpp holds to the truth.
TEST_P(QuadratureJobs, ConductorsThatAbsorbNothingAreDielectrics) {
    const std::string rest = R"("quantities":["specular_albedo"],"resolution":[5,3],"fresnel":)";
    for (const char* index : {"0.6", "1", "1.7"}) {
        const auto planes_of = [&](const std::string& model) {
            return bake(rest + R"({"model":)" + model + index + "}", GetParam())
                .outcome.table.planes;
        };
        EXPECT_EQ(planes_of(R"("conductor","k":0,"eta":)"), planes_of(R"("dielectric","ior":)"));
    }
}

TEST_P(QuadratureJobs, AveragesHoldAtRoughnessZero) {
    const auto first_of = [&](const std::string& microfacet) {
        return bake(R"("quantities":["average_albedo"],"resolution":[2],"layout":{"x":)"
                    R"({"parameter":"roughness","grid":"node"}},"microfacet":)" +
                        microfacet,
                    GetParam())
            .outcome.table.planes[0][0];
    };
    EXPECT_NEAR(first_of(R"({"distribution":"charlie","masking":"neubelt"})"), 0, 1e-15);
    EXPECT_NEAR(first_of(R"({"distribution":"charlie","masking":"charlie"})"), 0, 1e-15);
    EXPECT_EQ(first_of(R"({"masking":"smith_correlated"})"), 1);
    EXPECT_EQ(first_of(R"({"masking":"karis_ibl"})"), 1);  // k = 0
}

TEST_P(QuadratureJobs, SheenIsALobeOfItsOwn) {
    const auto planes_of = [&](const std::string& what) {
        return bake(R"("resolution":[5,3],"quantities":)" + what, GetParam()).outcome.table.planes;
    };
    const auto cloth = planes_of(R"(["directional_albedo"],"microfacet":{"distribution":"charlie",)"
                                 R"("masking":"neubelt"})");
    EXPECT_EQ(planes_of(R"(["directional_albedo","sheen_albedo"])")[1], cloth[0]);
}

struct Model {
    const char* fresnel;
    reference::Fresnel truth;
};

TEST_P(QuadratureJobs, AreThoseOfTheReferenceUnderEveryFresnelModel) {
    const Model models[] = {
        {R"({"model":"schlick","f0":0.04,"f90":0.9})", reference::fresnel_schlick(0.04, 0.9)},
        {R"({"model":"schlick","f0":0.3,"exponent":3.5})", reference::fresnel_schlick(0.3, 1, 3.5)},
        {R"({"model":"dielectric","ior":1.1})", reference::fresnel_dielectric(1.1)},
        {R"({"model":"dielectric","ior":2.4})", reference::fresnel_dielectric(2.4)},
        {R"({"model":"conductor","eta":1.5,"k":7})", reference::fresnel_conductor(1.5, 7)},
        {R"({"model":"edge_tint","reflectivity":0.9,"edge_tint":0.3})",
         reference::fresnel_edge_tint(0.9, 0.3)},
        {R"({"model":"f82_tint","f0":0.8,"f82":0.6})", reference::fresnel_f82_tint(0.8, 0.6)}};
    for (const char* masking : {"smith_correlated", "smith_separable"})
        for (const Model& model : models) {
            const std::string rest =
                R"("quantities":["specular_albedo"],"resolution":[3,3],"microfacet":{"masking":")" +
                std::string(masking) + R"("},"fresnel":)" + model.fresnel;
            const Baked baked = bake(rest, GetParam());
            for (std::size_t i = 0; i < 9; ++i) {
                const double NoV = (static_cast<double>(i % 3) + 0.5) / 3;
                const double roughness = (static_cast<double>(i / 3) + 0.5) / 3;
                const double alpha = roughness * roughness;
                const reference::Microfacet lobe{reference::Distribution::ggx,
                                                 std::string(masking) == "smith_correlated"
                                                     ? reference::Visibility::smith_correlated
                                                     : reference::Visibility::smith_separable,
                                                 alpha};
                EXPECT_NEAR(baked.outcome.table.planes[0][i],
                            reference::microfacet_albedo(lobe, NoV, model.truth), 6.1e-8)
                    << rest << " texel " << i;
            }
        }
}

TEST_P(QuadratureJobs, DeriveTheOtherQuantities) {
    const Baked baked =
        bake(R"("quantities":["directional_albedo","multiscatter_albedo","average_albedo",)"
             R"("compensated_albedo"],"fresnel":{"model":"dielectric","ior":1.5},)"
             R"("multiscatter":"kulla_conty",)" +
                 at(0.5, 0.25),
             GetParam());
    const auto& planes = baked.outcome.table.planes;
    EXPECT_NEAR(planes[0][0], 0.8572634355815696, 6e-8);
    EXPECT_NEAR(planes[1][0], 1 - 0.8572634355815696, 1e-8);
    EXPECT_NEAR(planes[2][0], 0.8823233826182513, 6e-8);
    // Kulla, Conty 2017 from published values: F_avg, E_avg and the single lobe's albedo.
    const double F_avg = 0.09177795934235122, E_avg = 0.8823233826182513;
    const double F_ms = F_avg * F_avg * E_avg / (1 - F_avg * (1 - E_avg));
    EXPECT_NEAR(planes[3][0], 0.06689850709319349 + F_ms * (1 - 0.8572634355815696), 1e-8);
    EXPECT_GT(baked.outcome.report.work.brdf_evaluations, 0u);
    EXPECT_GT(baked.outcome.report.work.fresnel_evaluations, 0u);
    EXPECT_GT(baked.outcome.report.work.multiscatter_evaluations, 0u);
}

// Cloth and total reflection: specular and average of a lobe that has a rule of its own.
TEST_P(QuadratureJobs, ServeEveryLobe) {
    const Baked cloth = bake(R"("quantities":["specular_albedo","average_albedo"],)"
                             R"("microfacet":{"distribution":"charlie","masking":"neubelt"},)"
                             R"("fresnel":{"model":"schlick","f0":0.04},)" +
                                 at(0.5, 0.25),
                             GetParam());
    const reference::Microfacet charlie{reference::Distribution::charlie,
                                        reference::Visibility::neubelt, 0.25};
    const auto& planes = cloth.outcome.table.planes;
    EXPECT_NEAR(planes[0][0],
                reference::microfacet_albedo(charlie, 0.5, reference::fresnel_schlick(0.04, 1)),
                6.1e-8);
    EXPECT_NEAR(planes[1][0], reference::microfacet_average(charlie), 7e-8);
    EXPECT_EQ(cloth.outcome.report.status, "converged");
    EXPECT_EQ(cloth.outcome.report.device.backend, GetParam());
    const Baked glass = bake(R"("quantities":["specular_albedo"],)"
                             R"("fresnel":{"model":"dielectric","ior":0.6667},)" +
                                 at(0.7, 0.1),
                             GetParam());
    EXPECT_NEAR(glass.outcome.table.planes[0][0],
                reference::microfacet_albedo(
                    {reference::Distribution::ggx, reference::Visibility::smith_correlated, 0.1},
                    0.7, reference::fresnel_dielectric(0.6667)),
                6.1e-8);
}

// In float arithmetic the exponents of Charlie's masking leave up to 3.3e-6 of E: 1e-6 is promised.
TEST_P(QuadratureJobs, CharlieInFloatIsWithin1e6) {
    for (const char* softened : {"false", "true"}) {
        const std::string rest =
            R"("quantities":["directional_albedo"],"resolution":[16,16],"microfacet":{)"
            R"("distribution":"charlie","masking":"charlie","terminator_softening":)" +
            std::string(softened) + "}";
        const auto plane = [&](const std::string& precision) {
            return bake(R"("precision":")" + precision + "\"," + rest, GetParam())
                .outcome.table.planes[0];
        };
        const auto single = plane("float32"), wide = plane("float64");
        for (std::size_t i = 0; i < wide.size(); ++i)
            EXPECT_NEAR(single[i], wide[i], 1e-6 * std::max(1.F, wide[i])) << softened << i;
    }
}

// What was sampled is held against it, whatever the lobe.
TEST(QuadratureJobsOfReports, HaveAReferenceForEveryLobe) {
    for (const char* model : {R"("microfacet":{"distribution":"beckmann"})",
                              R"("microfacet":{"distribution":"charlie","masking":"charlie"})",
                              R"("microfacet":{"masking":"karis_ibl"})",
                              R"("fresnel":{"model":"dielectric","ior":0.7})"}) {
        const JobSpec job =
            parse_job(R"({"quantities":["specular_albedo"],"resolution":[4,4],"sample_count":4096,)"
                      R"("device":"native",)" +
                      std::string(model) + "}");
        const Report report = Engine({}).run(job, Control{}).report;
        ASSERT_TRUE(report.error[0].reference_max) << model;
        EXPECT_GT(*report.error[0].reference_max, 0) << model;
        // Five standard errors, and what float sums and the 1e-6 of the reference leave.
        EXPECT_LE(*report.error[0].reference_max, 6.2 * *report.error[0].standard_error_max + 1e-5)
            << model;
    }
}

INSTANTIATE_TEST_SUITE_P(Devices, QuadratureJobs, testing::Values("native", "opencl"),
                         [](const auto& device) { return std::string(device.param); });

TEST(QuadratureDevices, GiveTheSameBits) {
    if (!opencl_is_here()) GTEST_SKIP() << "no OpenCL device on this machine";
    for (const char* precision : {"float32", "float64"}) {
        const std::string rest =
            R"("quantities":["split_sum_scale","split_sum_bias","average_albedo",)"
            R"("specular_albedo"],"fresnel":{"model":"conductor","eta":0.18,"k":3.4},)"
            R"("resolution":[24,24],"integrator":"quadrature","precision":")" +
            std::string(precision) + "\"";
        Engine engine({});
        const auto on = [&](const char* device) {
            return engine.run(parse_job("{" + rest + ",\"device\":\"" + device + "\"}"), Control{});
        };
        const Outcome native = on("native"), opencl = on("opencl");
        EXPECT_EQ(native.report.device.backend, "native");
        EXPECT_EQ(opencl.report.device.backend, "opencl");
        if (opencl.report.device.numerics != kStrictNumerics)
            GTEST_SKIP() << opencl.report.device.name << " rounds in its own way";
        EXPECT_EQ(native.table.planes, opencl.table.planes) << precision;
    }
}

TEST(QuadratureDevices, FallBackToNativeWithTheReason) {
    const std::string rest = R"("quantities":["directional_albedo"],"resolution":[4,4])";
    EngineOptions switched_off, native_alone;
    switched_off.opencl_disabled_reason = "switched off";
    native_alone.device = DeviceChoice::native;
    const Baked automatic = bake(rest, "auto", switched_off);
    EXPECT_EQ(automatic.outcome.report.device.backend, "native");
    EXPECT_EQ(automatic.outcome.report.device.fallback, "switched off");
    EXPECT_EQ(automatic.outcome.table.planes, bake(rest).outcome.table.planes);
    EXPECT_THROW(bake(rest, "opencl", switched_off), Error);
    EXPECT_THROW(bake(rest, "opencl", native_alone), Error);
}

// A conductor that hardly absorbs and whose eta is below 1 has the rim of total reflection beside
// the real axis: the orders run out, and the report says so instead of a tolerance.
TEST(QuadratureStatus, TellsWhereTheOrdersRunOut) {
    const Baked baked = bake(R"("quantities":["specular_albedo"],"resolution":[4,4],)"
                             R"("fresnel":{"model":"conductor","eta":0.6667,"k":1e-6})");
    const Report& report = baked.outcome.report;
    EXPECT_EQ(report.status, "budget_exhausted");
    ASSERT_FALSE(report.warnings.empty());
    EXPECT_NE(report.warnings.back().find("highest order"), std::string::npos);
    ASSERT_TRUE(report.error[0].reference_max);
    EXPECT_GT(*report.error[0].reference_max, 1e-9);
    // The error that it states holds.
    const reference::Fresnel truth = reference::fresnel_dielectric(0.6667);
    double worst = 0;
    for (std::size_t i = 0; i < 16; ++i) {
        const double NoV = (static_cast<double>(i % 4) + 0.5) / 4;
        const double roughness = (static_cast<double>(i / 4) + 0.5) / 4;
        const double exact = reference::microfacet_albedo(
            {reference::Distribution::ggx, reference::Visibility::smith_correlated,
             roughness * roughness},
            NoV, truth);
        worst = std::max(worst, std::abs(baked.outcome.table.planes[0][i] - exact));
    }
    EXPECT_LE(worst, 2 * *report.error[0].reference_max + 1e-6);
}

}  // namespace
}  // namespace kiln
