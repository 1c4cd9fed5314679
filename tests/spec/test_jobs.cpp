// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "server/base/sha256.h"
#include "server/spec/channels.h"
#include "server/spec/limits.h"
#include "server/spec/measurement_names.h"
#include "server/spec/spec.h"
#include "server/spec/words.h"
#include "tests/spec/valid_jobs.h"

namespace kiln {
namespace {

using test::kContractExample;

std::string key(const std::string& text) { return job_id(parse_job(text)); }

bool accepted(const std::string& text) {
    try {
        parse_job(text);
        return true;
    } catch (const InvalidJob&) {
        return false;
    }
}

TEST(Jobs, MinimalDocumentIsTheStructsDefaults) {
    JobSpec expected;
    expected.quantities = {Quantity::average_albedo};
    expected.resolution = {256, 256};
    expected.axes = {{.parameter = Parameter::NoV}, {.parameter = Parameter::roughness}};
    EXPECT_EQ(parse_job(R"({"quantities":["average_albedo"]})"), expected);
}

TEST(Jobs, EveryFieldArrives) {
    const JobSpec job =
        parse_job(R"({"kind":"lut","quantities":["directional_albedo","split_sum_bias"],
        "resolution":[32,128],"layout":{"x":{"parameter":"alpha","mapping":"sqrt","grid":"node"},
        "y":{"parameter":"NoV","mapping":"square","flip":true,"range":[0.25,0.75]}},
        "sample_count":77,
        "sampler":"lattice","importance":"ndf","microfacet":{"masking":"smith_separable"},
        "precision":"float64","device":"native","seed":9007199254740991,
        "output":{"format":"png","pixel":"uint8"}})");
    JobSpec expected;
    expected.quantities = {Quantity::directional_albedo, Quantity::split_sum_bias};
    expected.resolution = {32, 128};
    expected.layout = "custom";
    expected.axes = {{Parameter::alpha, Mapping::sqrt, Grid::node, false, 0, 1},
                     {Parameter::NoV, Mapping::square, Grid::center, true, 0.25, 0.75}};
    expected.sample_count = 77;
    expected.sampler = Sampler::lattice;
    expected.importance = Importance::ndf;
    expected.masking = Masking::smith_separable;
    expected.precision = Precision::float64;
    expected.device = DeviceChoice::native;
    expected.seed = 9007199254740991u;
    expected.format = ImageFormat::png;
    expected.pixel = PixelType::uint8;
    EXPECT_EQ(job, expected);
}

const std::string kDigest(64, 'a');

std::string with_digest(std::string text) {
    const std::string id = "\"sha256:" + kDigest + '"';
    for (std::size_t at = 0; (at = text.find("ID", at)) != text.npos; at += id.size())
        text.replace(at, 2, id);
    return text;
}

TEST(Jobs, MeasuredFieldsArrive) {
    const JobSpec job = parse_job(with_digest(
        R"({"kind":"atlas","measured":{"data":[ID,{"data":ID,"name":"b","phi_in":null,
        "extrapolation":{"l":0.5,"theta_in":"clamp"}}],"extrapolation":{"p":0.25},"phi_in":97.5,
        "theta_in":[0,30.5],"gutter":3,"fit_error_max":0.05},"device":"native",
        "resolution":[16,8],"output":{"format":"png","pixel":"rgb9e5"}})"));
    JobSpec expected;
    expected.kind = Kind::atlas;
    expected.resolution = {16, 8};
    expected.format = ImageFormat::png;
    expected.pixel = PixelType::rgb9e5;
    expected.measured.materials = {
        {kDigest, kDigest.substr(0, 12), {0.25, 0.3, ThetaInBeyond::reciprocity}, 97.5},
        {kDigest, "b", {0.25, 0.5, ThetaInBeyond::clamp}}};
    expected.measured.theta_in = {0, 30.5};
    expected.measured.gutter = 3;
    expected.measured.fit_error_max = 0.05;
    expected.device = DeviceChoice::native;
    EXPECT_EQ(job, expected);
}

TEST(Jobs, MeasuredDefaultsAreThoseOfTheStruct) {
    const JobSpec job = parse_job(with_digest(R"({"kind":"slices","measured":{"data":ID}})"));
    EXPECT_EQ(job.measured.materials.at(0).extrapolation, Extrapolation{});
    EXPECT_EQ(job.measured.theta_in,
              (std::vector<double>{0, 5, 10, 15, 20, 25, 30, 35, 40, 45, 50, 55, 60}));
    EXPECT_FALSE(job.measured.materials.at(0).phi_in || job.measured.conserve);
    EXPECT_FALSE(job.measured.fit_error_max);
    EXPECT_EQ(job.resolution, (std::vector<std::int64_t>{361, 181}));
    EXPECT_EQ(job.pixel, PixelType::half);
}

/// Each measured kind has sizes, angles and pixels of its own, and its canonical text nothing that
/// it does not read.
TEST(Jobs, MeasuredKindsHaveDefaultsOfTheirOwn) {
    const auto job = [](const char* kind) {
        return parse_job(
            with_digest(std::string(R"({"measured":{"data":ID},"kind":")") + kind + "\"}"));
    };
    const JobSpec lobe = job("lobe_view"), sphere = job("sphere_view");
    EXPECT_EQ(lobe.measured.theta_in, std::vector<double>{30});
    EXPECT_EQ(lobe.resolution, (std::vector<std::int64_t>{640, 480}));
    EXPECT_EQ(sphere.resolution, (std::vector<std::int64_t>{512, 512}));
    EXPECT_TRUE(lobe.pixel == PixelType::uint8 && sphere.format == ImageFormat::png);
    EXPECT_EQ(job("companion").resolution, std::vector<std::int64_t>{64});
    EXPECT_EQ(job("sampling").resolution, (std::vector<std::int64_t>{96, 64}));
    EXPECT_EQ(job("sampling").pixel, PixelType::float32);
    EXPECT_EQ(job("sampling").measured.theta_in.size(), 13u);
    for (const char* unread : {"theta_in\":[", "gutter", "fit_error_max", "output"})
        EXPECT_EQ(canonical(sphere).find(unread), std::string::npos) << unread;
    EXPECT_NE(canonical(lobe).find("theta_in\":[30"), std::string::npos);
}

TEST(Jobs, SpellingsOfMeasuredAreOneJob) {
    const auto id = [](const char* measured) {
        return job_id(
            parse_job(with_digest(std::string(R"({"kind":"atlas","measured":)") + measured + "}")));
    };
    const std::string one = id(R"({"data":ID})");
    for (const char* same :
         {R"({"data":[ID]})", "[ID]", R"([{"data":ID}])", R"({"data":ID,"gutter":0.0})",
          R"({"data":[{"data":ID,"extrapolation":{"p":1}}],"extrapolation":{"p":0.5}})",
          R"({"data":[{"data":ID,"phi_in":null}],"phi_in":360})"})
        EXPECT_EQ(id(same), one) << same;
    for (const char* other :
         {R"({"data":ID,"name":"x"})", R"({"data":ID,"phi_in":0})", R"({"data":[ID,ID]})",
          R"({"data":ID,"theta_in":[0,20,40]})", R"({"data":ID,"conserve":true})",
          R"({"data":ID,"fit_error_max":0.1})", R"({"data":ID,"extrapolation":{"l":0.31}})"})
        EXPECT_NE(id(other), one) << other;
}

TEST(Jobs, MeasurementsAreFoundAndReplaced) {
    EXPECT_EQ(measurement_pointers(R"({"measured":{"data":"a"}})"),
              std::vector<std::string>{"/measured/data"});
    EXPECT_EQ(measurement_pointers(R"({"measured":[{"data":"a"},"b"]})"),
              (std::vector<std::string>{"/measured/0/data", "/measured/1"}));
    const auto shout = [](const std::string& name) { return name + "!"; };
    EXPECT_EQ(with_measurements(R"({"measured":{"data":["a",{"data":"b"},5]}})", shout),
              R"({"measured":{"data":["a!",{"data":"b!"},5]}})");
    for (const char* left : {R"({"kind":"lut"})", "[", R"({"measured":3})", "7"})
        EXPECT_EQ(with_measurements(left, shout), left);
    std::set<std::string> named;
    named_measurements("\"sha256:" + kDigest + "\" sha256:0 \"sha256:" + kDigest + "\"", named);
    EXPECT_EQ(named, std::set<std::string>{kDigest});
}

TEST(Jobs, ValidDocumentsSurviveTheirCanonicalForm) {
    for (const std::string& text : test::kValidJobs) {
        SCOPED_TRACE(text);
        const JobSpec job = parse_job(text);
        EXPECT_EQ(parse_job(canonical(job)), job);
        EXPECT_EQ(canonical(parse_job(canonical(job))), canonical(job));
        EXPECT_TRUE(is_sha256_hex(job_id(job)));
    }
}

TEST(Jobs, CanonicalTextIsTheContractsDocument) {
    const std::string text = canonical(parse_job(kContractExample));
    EXPECT_EQ(
        text,
        R"({"coupling":"none","device":"auto","diffuse":{"model":"lambert"},)"
        R"("fresnel":{"model":"schlick"},"importance":"vndf","integrator":"monte_carlo",)"
        R"("kind":"lut",)"
        R"("layout":"kiln","microfacet":{"distribution":"ggx","masking":"smith_correlated"},)"
        R"("multiscatter":"none","output":{"format":"exr","pixel":"half"},"precision":"float32",)"
        R"("quantities":["split_sum_scale","split_sum_bias"],"resolution":[256,256],)"
        R"("sample_count":1024,"sampler":"sobol_owen","seed":0,"target_error":null,)"
        R"("time_budget_s":null})");
    EXPECT_EQ(job_id(parse_job(kContractExample)), sha256_hex("kiln/job/1\n" + text));
}

// 2^20 samples of one texel are allowed; of 256², 2^18 are the most below 2e10 samples.
TEST(Jobs, WhatStopsByItselfTakesAsManySamplesAsMayBe) {
    const auto samples = [](const std::string& fields) {
        return parse_job(R"({"quantities":["split_sum_bias"],)" + fields + "}").sample_count;
    };
    EXPECT_EQ(samples(R"("target_error":1e-3)"), 262144);
    EXPECT_EQ(samples(R"("time_budget_s":1)"), 262144);
    EXPECT_EQ(samples(R"("target_error":1e-3,"resolution":[16,16])"), 1048576);
    EXPECT_EQ(samples(R"("target_error":1e-3,"resolution":[4096,4096])"), 1024);
    EXPECT_EQ(samples(R"("target_error":1e-3,"sample_count":4096)"), 4096);
    EXPECT_EQ(samples(R"("target_error":null)"), 1024);
    const JobSpec job =
        parse_job(R"({"quantities":["split_sum_bias"],"target_error":0.25,"time_budget_s":2})");
    EXPECT_EQ(job.target_error, 0.25);
    EXPECT_EQ(job.time_budget_s, 2.0);
    EXPECT_FALSE(parse_job(kContractExample).target_error.has_value());
    EXPECT_FALSE(parse_job(kContractExample).time_budget_s.has_value());
}

TEST(Jobs, PixelDefaultsFollowTheFormat) {
    EXPECT_EQ(parse_job(R"({"quantities":["average_albedo"]})").pixel, PixelType::half);
    EXPECT_EQ(parse_job(R"({"quantities":["average_albedo"],"output":{"format":"png"}})").pixel,
              PixelType::uint16);
}

TEST(Jobs, OneAxisOfKilnIsRoughness) {
    const JobSpec job = parse_job(R"({"quantities":["average_albedo"],"resolution":[64]})");
    EXPECT_EQ(job.layout, "kiln");
    ASSERT_EQ(job.axes.size(), 1u);
    EXPECT_EQ(job.axes[0], Axis{.parameter = Parameter::roughness});
}

TEST(Jobs, SpellingDoesNotSplitTheCache) {
    const std::string id = key(kContractExample);
    const char* same[] = {
        R"({"quantities":["split_sum_scale","split_sum_bias"]})",
        "\n\t{ \"seed\" : 0.0 ,\r\n\"quantities\":[ \"split_sum_scale\" , \"split_sum_bias\" ] }  ",
        R"({"seed":0,"quantities":["split_sum_scale","split_sum_bias"],"kind":"lut"})",
        R"({"quantities":["split_sum_scale","split_sum_bias"],"resolution":[256.0,2.56e2]})",
        R"({"quantities":["split_sum_scale","split_sum_bias"],"sample_count":1.024E+3,"seed":-0})",
        R"({"quantities":["split_sum_scale","split_sum_bias"],"seed":-0.0})",
        R"({"qu\u0061ntities":["split_sum_sc\u0061le","split_sum_bias"]})",
        R"({"output":{"pixel":"half"},"quantities":["split_sum_scale","split_sum_bias"]})",
        R"({"output":{},"quantities":["split_sum_scale","split_sum_bias"],"microfacet":{}})",
        R"({"quantities":["split_sum_scale","split_sum_bias"],
            "layout":{"y":{"parameter":"roughness","range":[-0.0,1.0]},"x":{"parameter":"NoV"}}})",
    };
    for (const char* text : same) EXPECT_EQ(key(text), id) << text;
}

TEST(Jobs, MeaningDoesSplitTheCache) {
    const char* different[] = {
        R"({"quantities":["split_sum_scale","split_sum_bias"]})",
        R"({"quantities":["split_sum_bias","split_sum_scale"]})",
        R"({"quantities":["split_sum_scale"]})",
        R"({"quantities":["split_sum_scale","split_sum_bias"],"resolution":[256,255]})",
        R"({"quantities":["split_sum_scale","split_sum_bias"],"resolution":[255,256]})",
        R"({"quantities":["split_sum_scale","split_sum_bias"],"sample_count":1025})",
        R"({"quantities":["split_sum_scale","split_sum_bias"],"target_error":0.25})",
        R"({"quantities":["split_sum_scale","split_sum_bias"],"target_error":0.5})",
        R"({"quantities":["split_sum_scale","split_sum_bias"],"time_budget_s":0.5})",
        R"({"quantities":["split_sum_scale","split_sum_bias"],"time_budget_s":0.25})",
        R"({"quantities":["split_sum_scale","split_sum_bias"],"sampler":"lattice"})",
        R"({"quantities":["split_sum_scale","split_sum_bias"],"importance":"ndf"})",
        R"({"quantities":["split_sum_scale","split_sum_bias"],
            "microfacet":{"masking":"smith_separable"}})",
        R"({"quantities":["split_sum_scale","split_sum_bias"],"precision":"float64"})",
        R"({"quantities":["split_sum_scale","split_sum_bias"],"device":"native"})",
        R"({"quantities":["split_sum_scale","split_sum_bias"],"seed":1})",
        R"({"quantities":["split_sum_scale","split_sum_bias"],"seed":9007199254740991})",
        R"({"quantities":["split_sum_scale","split_sum_bias"],"seed":9007199254740990})",
        R"({"quantities":["split_sum_scale","split_sum_bias"],"output":{"pixel":"float"}})",
        R"({"quantities":["split_sum_scale","split_sum_bias"],"output":{"format":"png"}})",
        R"({"quantities":["split_sum_scale","split_sum_bias"],
            "layout":{"x":{"parameter":"NoV","flip":true},"y":{"parameter":"roughness"}}})",
        R"({"quantities":["split_sum_scale","split_sum_bias"],
            "layout":{"x":{"parameter":"NoV","range":[0,0.9999999999999999]},
            "y":{"parameter":"roughness"}}})",
    };
    std::set<std::string> ids;
    for (const char* text : different) ids.insert(key(text));
    EXPECT_EQ(ids.size(), std::size(different));
}

TEST(Jobs, LimitsHoldExactly) {
    const auto with = [](const std::string& field) {
        return R"({"quantities":["split_sum_scale"],)" + field + "}";
    };
    const auto both = [&](const std::string& before, std::int64_t limit, const std::string& after) {
        EXPECT_TRUE(accepted(with(before + std::to_string(limit) + after))) << before << limit;
        EXPECT_FALSE(accepted(with(before + std::to_string(limit + 1) + after)))
            << before << limit + 1;
    };
    both("\"resolution\":[1,", limits().resolution_max, "]");
    both("\"resolution\":[", limits().resolution_max, ",1]");
    both("\"resolution\":[4,4],\"sample_count\":", limits().sample_count_max, "");
    both("\"seed\":", (std::int64_t{1} << 53) - 1, "");
    const std::int64_t texels = limits().resolution_max * limits().resolution_max;
    both("\"resolution\":[4096,4096],\"sample_count\":", limits().work_samples_max / texels, "");
    EXPECT_FALSE(accepted(with("\"resolution\":[1,0]")));
    EXPECT_FALSE(accepted(with("\"sample_count\":0")));
    EXPECT_GE(limits().work_samples_max, texels * 1024);  // the largest table at the usual count
}

TEST(Jobs, BodyAndDepthLimitsHoldExactly) {
    std::string text = R"({"quantities":["split_sum_scale"]})";
    text.resize(static_cast<std::size_t>(limits().job_bytes_max), ' ');
    EXPECT_TRUE(accepted(text));
    EXPECT_THROW(parse_job(text + " "), Malformed);
    const auto nested = [](std::int64_t depth) {
        const auto count = static_cast<std::size_t>(depth);
        return std::string(count, '[') + std::string(count, ']');
    };
    EXPECT_THROW(parse_job(nested(limits().depth_max)), InvalidJob);
    EXPECT_THROW(parse_job(nested(limits().depth_max + 1)), Malformed);
}

}  // namespace
}  // namespace kiln
