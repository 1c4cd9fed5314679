// SPDX-License-Identifier: Apache-2.0
// Every model of the general path on OpenCL: the bits of native. A program a model takes the
// driver's compiler half a second to a second, so each distribution, masking, importance, Fresnel
// and diffuse model, coupling and multiple scattering is in one job, not in every combination.
#include <gtest/gtest.h>
#include <stdlib.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "server/base/error.h"
#include "server/compute/engine.h"
#include "server/compute/opencl_programs.h"
#include "server/spec/spec.h"
#include "server/spec/words.h"

namespace kiln {
namespace {

/// A kernel cache of its own, so that a test sees what the compiler makes today.
class OpenClModels : public testing::Test {
  protected:
    static void SetUpTestSuite() {
        std::string name = KILN_BINARY_DIR "/opencl-models-XXXXXX";
        ASSERT_NE(mkdtemp(name.data()), nullptr);
        folder_ = name;
        setenv("POCL_CACHE_DIR", folder_.c_str(), 1);
        EngineOptions options;
        options.opencl_wait = std::chrono::minutes(5);
        engine_ = std::make_unique<Engine>(options);
    }
    static void TearDownTestSuite() {
        engine_.reset();
        std::filesystem::remove_all(folder_);
    }

    /// One job on both. Skips the test where there is no device.
    static void expect_equal_bits(const std::string& fields, int sample_count = 256) {
        const auto on = [&](const char* device) {
            const std::string text = R"({"resolution":[16,8],"sample_count":)" +
                                     std::to_string(sample_count) + R"(,"device":")" + device +
                                     "\"," + fields + "}";
            return engine_->run(parse_job(text), Control{});
        };
        Outcome opencl;
        try {
            opencl = on("opencl");
        } catch (const Error& error) {
            if (error.code() != "device_unavailable") throw;
            GTEST_SKIP() << error.what();
        }
        const Outcome native = on("native");
        EXPECT_EQ(opencl.report.device.backend, "opencl") << fields;
        EXPECT_EQ(opencl.report.device.numerics, native.report.device.numerics) << fields;
        ASSERT_EQ(opencl.table.planes.size(), native.table.planes.size());
        for (std::size_t c = 0; c < native.table.planes.size(); ++c)
            EXPECT_EQ(std::memcmp(opencl.table.planes[c].data(), native.table.planes[c].data(),
                                  native.table.planes[c].size() * sizeof(float)),
                      0)
                << native.table.channels[c] << " of " << fields;
    }

    static std::string folder_;
    static std::unique_ptr<Engine> engine_;
};
std::string OpenClModels::folder_;
std::unique_ptr<Engine> OpenClModels::engine_;

const std::string kFresnel[] = {
    R"({"model":"none"})",
    R"({"model":"schlick","f0":0.3,"exponent":4})",
    R"({"model":"dielectric","ior":1.5})",
    R"({"model":"conductor","metal":"copper"})",
    R"({"model":"edge_tint","reflectivity":[0.9,0.6,0.3],"edge_tint":0.4})",
    R"({"model":"f82_tint","f0":[0.9,0.6,0.3],"f82":0.8})",
};
static_assert(std::size(kFresnel) == static_cast<std::size_t>(Fresnel::f82_tint) + 1);

/// Whether the contract has such a lobe.
bool takes(std::string_view distribution, std::string_view masking) {
    try {
        parse_job(R"({"quantities":["directional_albedo"],"microfacet":{"distribution":")" +
                  std::string(distribution) + R"(","masking":")" + std::string(masking) + "\"}}");
    } catch (const InvalidJob&) {
        return false;
    }
    return true;
}

TEST_F(OpenClModels, EveryLobeAndFresnelTerm) {
    struct Lobe {
        const char *distribution, *masking, *importance;
        int fresnel;
    };
    const std::vector<Lobe> lobes = {
        {"ggx", "smith_correlated", "vndf", 2},
        {"ggx", "smith_separable", "cosine", 3},
        {"ggx", "karis_ibl", "ndf", 4},
        {"ggx", "karis_direct", "uniform", 5},
        {"ggx", "unreal_joint", "vndf", 0},
        {"beckmann", "smith_correlated", "vndf", 3},
        {"beckmann", "smith_separable", "ndf", 1},
        {"charlie", "neubelt", "uniform", 4},
        {"charlie", "charlie", "cosine", 2},
    };
    std::size_t taken = 0;
    for (const std::string_view distribution : words<Distribution>())
        for (const std::string_view masking : words<Masking>()) {
            if (!takes(distribution, masking)) continue;
            ++taken;
            EXPECT_TRUE(std::any_of(lobes.begin(), lobes.end(),
                                    [&](const Lobe& lobe) {
                                        return lobe.distribution == distribution &&
                                               lobe.masking == masking;
                                    }))
                << distribution << ' ' << masking;
        }
    EXPECT_EQ(taken, lobes.size());
    for (const Lobe& lobe : lobes)
        expect_equal_bits(R"("quantities":["specular_albedo","split_sum_bias",)"
                          R"("multiscatter_albedo"],"microfacet":{"distribution":")" +
                          std::string(lobe.distribution) + R"(","masking":")" + lobe.masking +
                          R"("},"importance":")" + lobe.importance + R"(","fresnel":)" +
                          kFresnel[lobe.fresnel]);
    expect_equal_bits(R"("quantities":["directional_albedo"],"microfacet":{"distribution":)"
                      R"("charlie","masking":"charlie","terminator_softening":true})");
    expect_equal_bits(
        R"("quantities":["average_albedo"],"microfacet":{"distribution":"beckmann"})");
    expect_equal_bits(R"("quantities":["directional_albedo","sheen_albedo"])");
}

// From 4096 samples on, low roughness has a kernel of its own (region.cpp).
TEST_F(OpenClModels, VisibleLights) {
    expect_equal_bits(R"("quantities":["split_sum_scale","split_sum_bias"])", 4096);
    expect_equal_bits(R"("quantities":["specular_albedo"],"fresnel":)" + std::string(kFresnel[2]),
                      4096);
}

// Where light is reflected totally F has a kernel of its own too, beside E's and 1 − E's.
TEST_F(OpenClModels, PartedLights) {
    const std::string inside = R"("fresnel":{"model":"dielectric","ior":0.7})";
    expect_equal_bits(R"("quantities":["specular_albedo"],)" + inside, 4096);
    expect_equal_bits(
        R"("quantities":["specular_albedo"],"microfacet":{"distribution":"beckmann"},)" + inside,
        4096);
    expect_equal_bits(R"("quantities":["total_albedo"],"multiscatter":"kulla_conty","coupling":)"
                      R"("half_vector","diffuse":{"model":"oren_nayar_full","albedo":0.8},)" +
                          inside,
                      4096);
}

// Beside the lobe itself the term that a half-vector coupling reads; a walk has none.
TEST_F(OpenClModels, EveryDiffuseModel) {
    for (const std::string_view model : words<DiffuseModel>()) {
        if (model == "none") continue;
        const bool simulated = model == "ggx_lambert";
        expect_equal_bits(R"("quantities":["diffuse_albedo","total_albedo"],"fresnel":)" +
                          kFresnel[2] + R"(,"coupling":")" + (simulated ? "none" : "half_vector") +
                          R"(","diffuse":{"model":")" + std::string(model) +
                          R"(","albedo":[0.9,0.5,0.1]})");
    }
    expect_equal_bits(R"("quantities":["diffuse_average_albedo"],"diffuse":{"model":"eon"})");
    expect_equal_bits(
        R"("quantities":["diffuse_average_albedo"],"diffuse":{"model":"ggx_lambert"})");
}

TEST_F(OpenClModels, EveryCouplingAndMultiscatter) {
    const std::string common = R"("quantities":["total_albedo","compensated_albedo"],"fresnel":)" +
                               kFresnel[2] + R"(,"diffuse":{"model":"lambert","albedo":0.7},)";
    const std::vector<std::pair<std::string, std::string>> pairs = {
        {"none", "kulla_conty"},
        {"half_vector", "turquin"},
        {"view", "none"},
        {"kelemen", "kulla_conty_linear"}};
    ASSERT_EQ(pairs.size(), words<Coupling>().size());
    ASSERT_EQ(pairs.size(), words<Multiscatter>().size());
    for (const auto& [coupling, multiscatter] : pairs)
        expect_equal_bits(common + R"("coupling":")" + coupling + R"(","multiscatter":")" +
                          multiscatter + "\"");
}

TEST_F(OpenClModels, InDoublePrecision) {
    for (const char* rest :
         {R"("quantities":["specular_albedo"],"microfacet":{"distribution":"charlie"},)"
          R"("fresnel":{"model":"conductor","eta":0.2,"k":3.9})",
          R"("quantities":["diffuse_albedo"],"diffuse":{"model":"ggx_lambert","albedo":0.5})"})
        expect_equal_bits(std::string(rest) + R"(,"precision":"float64")");
}

// More often than a device may fail before it is given up.
TEST_F(OpenClModels, ValuesThatNoDeviceHasAreNoFaultOfTheDevice) {
    const auto charlie = [](const std::string& NoV_grid, const std::string& rest) {
        return parse_job(
            R"({"microfacet":{"distribution":"charlie","masking":"neubelt"},"sample_count":256,)"
            R"("resolution":[4,4],"layout":{"y":{"parameter":"roughness","grid":"node"},)"
            R"("x":{"parameter":"NoV","grid":")" +
            NoV_grid + R"("}},"quantities":[)" + rest + "}");
    };
    const auto message = [](const JobSpec& job) {
        try {
            engine_->run(job, Control{});
        } catch (const Error& error) {
            return error.code() + ": " + error.what();
        }
        return std::string("baked");
    };
    const JobSpec unbounded = charlie("node", R"("specular_albedo"])");
    const JobSpec turquin = charlie("center", R"("compensated_albedo"],"multiscatter":"turquin")");
    for (int n = 0; n <= kDeviceFailuresMax; ++n) {
        EXPECT_EQ(message(unbounded).rfind("non_finite: of the values of the table 1 is not", 0),
                  0U)
            << message(unbounded);
        EXPECT_EQ(message(turquin).rfind("non_finite: Turquin's factor", 0), 0U)
            << message(turquin);
    }
    expect_equal_bits(R"("quantities":["specular_albedo"])");
}

}  // namespace
}  // namespace kiln
