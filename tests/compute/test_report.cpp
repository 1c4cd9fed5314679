// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>

#include "server/base/error.h"
#include "server/compute/report.h"

namespace {

using namespace kiln;
using Json = nlohmann::json;

Report full() {
    Report r;
    r.job = std::string(64, 'a');
    r.device = {
        .backend = "native", .name = "x86-64-v4", .numerics = "n1", .fallback = "no device"};
    r.samples_per_texel = 1024;
    r.samples_total = 18446744073709551615U;
    r.replicates = 16;
    r.run_time_s = {.queued = 0.5,
                    .compile = 1,
                    .integrate = 2,
                    .assemble = 0.25,
                    .reference = 0.05,
                    .encode = 0.1,
                    .total = 3.5};
    r.error = {{.quantity = "split_sum_scale",
                .standard_error_rms = 1e-4,
                .standard_error_max = 2e-4,
                .reference_rms = 3e-4,
                .reference_max = 4e-4,
                .reconstruction_max = 5e-4,
                .quantisation_max = 0,
                .reference_texels = 4096}};
    r.error.emplace_back().quantity = "average_albedo";
    r.trace = {{.sample_count = 64,
                .elapsed_s = 0.25,
                .standard_error_rms = {},
                .standard_error_max = 0.125}};
    r.work = {.brdf_evaluations = 7, .fresnel_evaluations = 8, .multiscatter_evaluations = 9};
    r.left_out = {{"multiscatter", "nobody asked"}};
    r.warnings = {"say \"hm\"\n"};
    return r;
}

TEST(Report, IsTheContractsDocument) {
    // Written out by hand after the contract's example; values as in full().
    const Json expected = Json::parse(R"({
      "job": "aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa", "status": "done",
      "device": {"backend": "native", "name": "x86-64-v4", "numerics": "n1",
                 "fallback": "no device"},
      "samples": {"per_texel": 1024, "total": 18446744073709551615, "replicates": 16},
      "run_time_s": {"queued": 0.5, "compile": 1.0, "integrate": 2.0, "assemble": 0.25,
                     "reference": 0.05, "encode": 0.1, "total": 3.5},
      "error": {
        "split_sum_scale": {"standard_error_rms": 1e-4, "standard_error_max": 2e-4,
          "reference_rms": 3e-4, "reference_max": 4e-4, "reference_texels": 4096,
          "reconstruction_max": 5e-4, "quantisation_max": 0.0},
        "average_albedo": {"standard_error_rms": null, "standard_error_max": null,
          "reference_rms": null, "reference_max": null, "reference_texels": null,
          "reconstruction_max": null, "quantisation_max": null}},
      "trace": [{"sample_count": 64, "elapsed_s": 0.25, "standard_error_rms": null,
                 "standard_error_max": 0.125}],
      "work": {"brdf_evaluations": 7, "fresnel_evaluations": 8, "multiscatter_evaluations": 9},
      "left_out": [{"what": "multiscatter", "why": "nobody asked"}],
      "warnings": ["say \"hm\"\n"]})");
    const Json written = Json::parse(to_json(full()));
    EXPECT_EQ(written, expected) << written.dump(1);
    EXPECT_EQ(to_json(full()).substr(0, 8), R"({"job":")");  // fields stand in the contract's order
}

TEST(Report, EmptyListsStayListsAndNoFallbackIsNull) {
    const Json written = Json::parse(to_json(Report{}));
    EXPECT_EQ(written.at("error"), Json::object());
    for (const char* list : {"trace", "left_out", "warnings"})
        EXPECT_EQ(written.at(list), Json::array()) << list;
    EXPECT_TRUE(written.at("device").at("fallback").is_null());
    Report one_warning;
    one_warning.warnings = {"a"};
    EXPECT_EQ(Json::parse(to_json(one_warning)).at("warnings"), Json::array({"a"}));
}

TEST(Report, NonFiniteNumbersAreRefusedByName) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const double infinite = std::numeric_limits<double>::infinity();
    const std::vector<std::pair<std::string, void (*)(Report&, double)>> places = {
        {"run_time_s.integrate", [](Report& r, double v) { r.run_time_s.integrate = v; }},
        {"run_time_s.assemble", [](Report& r, double v) { r.run_time_s.assemble = v; }},
        {"standard_error_max", [](Report& r, double v) { r.error[0].standard_error_max = v; }},
        {"quantisation_max", [](Report& r, double v) { r.error[1].quantisation_max = v; }},
        {"elapsed_s", [](Report& r, double v) { r.trace[0].elapsed_s = v; }},
    };
    for (const auto& [name, set] : places)
        for (const double bad : {nan, infinite, -infinite}) {
            Report report = full();
            set(report, bad);
            try {
                to_json(report);
                ADD_FAILURE() << name;
            } catch (const Error& e) {
                EXPECT_EQ(e.code(), "non_finite");
                EXPECT_NE(std::string(e.what()).find(name), std::string::npos) << e.what();
            }
        }
}

TEST(Report, TwoErrorsForOneQuantityAreAFault) {
    Report report = full();
    report.error[1].quantity = report.error[0].quantity;
    EXPECT_THROW(to_json(report), Error);
}

TEST(Report, ADriversBrokenNameDoesNotFailTheJob) {
    Report report;
    report.device.name = "GPU \xff";
    EXPECT_EQ(Json::parse(to_json(report)).at("device").at("name"), "GPU \xef\xbf\xbd");
}

}  // namespace
