// SPDX-License-Identifier: Apache-2.0
// Jobs of kind slices and atlas, from the job's text to image, side-car and report.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "server/base/error.h"
#include "server/base/sha256.h"
#include "server/image/image.h"
#include "server/spec/contract.h"
#include "server/spec/spec.h"
#include "server/worker/bake.h"
#include "tests/compute/opencl_cache.h"
#include "tests/measured/synthetic.h"

namespace kiln {
namespace {

using Json = nlohmann::json;

/// Measured every five degrees.
std::string file_of(const synthetic::Material& surface) {
    synthetic::MiniDiffGrid grid;
    grid.azimuth_step = grid.radial_step = 5;
    return synthetic::minidiff_file(surface, grid);
}

/// Two lobes, which one cannot stand for.
synthetic::Material two_lobes() {
    const auto narrow = synthetic::ggx(0.12, {0.3, 0.3, 0.3}, {0.1, 0.1, 0.1});
    const auto wide = synthetic::ggx(0.6, {0.9, 0.6, 0.3}, {0.1, 0.1, 0.1});
    return [=](const synthetic::Cosines& at) {
        std::array<double, 3> sum = narrow(at);
        for (std::size_t k = 0; k < 3; ++k) sum[k] += wide(at)[k];
        return sum;
    };
}

const std::string& paint() {
    static const std::string file = file_of(synthetic::lambert({0.3, 0.5, 0.7}));
    return file;
}
const std::string& lacquer() {
    static const std::string file = file_of(two_lobes());
    return file;
}

std::string bytes_of(const std::string& digest) {
    return digest == sha256_hex(paint()) ? paint() : lacquer();
}

/// An atlas of lacquer and paint with more fields.
JobSpec job_of(const std::string& measured_fields, const std::string& fields = "") {
    return parse_job(
        R"({"kind":"atlas","resolution":[37,19],"measured":{"data":[{"data":"sha256:)" +
        sha256_hex(lacquer()) + R"(","name":"lacquer"},{"data":"sha256:)" + sha256_hex(paint()) +
        R"(","name":"paint"}],"theta_in":[0,30,70])" + measured_fields + "}" + fields + "}");
}

Baked baked(const EngineOptions& options, const JobSpec& job) {
    Engine engine(options);
    return bake(engine, job, {}, bytes_of);
}

EngineOptions options(DeviceChoice device, const std::string& opencl_off = "") {
    EngineOptions options;
    options.device = device;
    options.opencl_disabled_reason = opencl_off;
    return options;
}
const EngineOptions kNative = options(DeviceChoice::native);

/// Whatever runs it, a job's image and side-car have the same bits.
TEST(MeasuredJob, OpenClGivesTheBitsOfNative) {
    test::use_own_opencl_cache();
    const JobSpec job = job_of("");
    Baked there;
    try {
        there = baked(options(DeviceChoice::opencl), job);
    } catch (const Error& error) {
        GTEST_SKIP() << error.what();
    }
    const Baked here = baked(kNative, job);
    EXPECT_EQ(there.report.device.backend, "opencl");
    EXPECT_EQ(here.report.device.backend, "native");
    EXPECT_EQ(there.report.device.numerics, here.report.device.numerics);
    EXPECT_EQ(there.image_digest, here.image_digest);
    EXPECT_EQ(there.sidecar, here.sidecar);
}

TEST(MeasuredJob, AutoFallsBackAndSaysWhy) {
    const EngineOptions off = options(DeviceChoice::automatic, "switched off");
    EXPECT_EQ(baked(off, job_of("")).report.device.fallback, "switched off");
    EXPECT_FALSE(baked(off, job_of("", R"(,"device":"native")")).report.device.fallback);
    try {
        baked(off, job_of("", R"(,"device":"opencl")"));
        FAIL();
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), "device_unavailable");
    }
}

/// Albedos above 1 and f(i, o) other than f(o, i), before and after.
TEST(MeasuredJob, ConservesOnRequest) {
    const Json sidecar = Json::parse(baked(kNative, job_of(R"(,"conserve":true)")).sidecar);
    EXPECT_TRUE(contract_problems("SideCar", sidecar.dump()).empty());
    EXPECT_EQ(sidecar["conserved"], true);
    const Json& lacquer = sidecar["materials"][0];
    EXPECT_GT(lacquer["physics_as_measured"]["albedo_max"], 1.05);
    EXPECT_LT(lacquer["physics"]["albedo_max"], 1.0005);
    EXPECT_GT(lacquer["physics_as_measured"]["reciprocity"]["mean"], 0.003);
    EXPECT_LT(lacquer["physics"]["reciprocity"]["mean"], 1e-5);
    EXPECT_EQ(lacquer["physics"]["albedo"].size(), 19u);
    const Json plain = Json::parse(baked(kNative, job_of("")).sidecar);
    EXPECT_FALSE(plain["materials"][0].contains("physics_as_measured"));
    EXPECT_GT(plain["materials"][0]["physics"]["albedo_max"], 1.05);
    // Per slice: 0 is measured, 30 lies between, 70 beyond.
    const Json& slices = plain["materials"][0]["slices"];
    EXPECT_LT(slices[0]["predicted_error"], slices[1]["predicted_error"]);
    EXPECT_TRUE(slices[2]["predicted_error"].is_null());
}

TEST(MeasuredJob, LeavesOutOfTheAtlasWhatParametersAreWithin) {
    const Baked baked_both = baked(kNative, job_of(R"(,"fit_error_max":0.01)"));
    const Json sidecar = Json::parse(baked_both.sidecar);
    EXPECT_TRUE(contract_problems("SideCar", sidecar.dump()).empty());
    ASSERT_EQ(sidecar["materials"].size(), 1u);
    EXPECT_EQ(sidecar["materials"][0]["name"], "lacquer");
    ASSERT_EQ(sidecar["fitted"].size(), 1u);
    const Json& paint = sidecar["fitted"][0];
    EXPECT_EQ(paint["name"], "paint");
    EXPECT_TRUE(paint["left_out"]);
    EXPECT_NEAR(paint["diffuse"][1].get<double>(), 0.5, 0.005);
    EXPECT_LT(paint["error_worst"], 0.01);
    ASSERT_EQ(baked_both.report.left_out.size(), 1u);
    EXPECT_EQ(baked_both.report.left_out[0].what, "paint");
    // Two slices a row, one cell in each: what the file says of itself is of what it holds.
    const Decoded image = decode(baked_both.image);
    EXPECT_EQ(image.table.width, 2u * 37);
    const auto wanted = std::find_if(image.metadata.begin(), image.metadata.end(),
                                     [](const auto& one) { return one.first == "kiln.job"; });
    ASSERT_NE(wanted, image.metadata.end());
    EXPECT_EQ(parse_job(wanted->second).measured.materials.size(), 1u);
    // Everything within: one cell stays.
    const Baked all = baked(kNative, job_of(R"(,"fit_error_max":1)"));
    EXPECT_EQ(Json::parse(all.sidecar)["materials"].size(), 1u);
    EXPECT_EQ(Json::parse(all.sidecar)["fitted"].size(), 2u);
}

}  // namespace
}  // namespace kiln
