// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "server/compute/engine.h"
#include "server/compute/facet_albedos.h"
#include "server/spec/spec.h"
#include "tests/compute/against_reference.h"
#include "tests/reference/ggx_lambert.h"

// Jobs of ggx_lambert by quadrature, beside sums over orders.
namespace kiln {
namespace {

using against_reference::bake;
using Values = std::vector<double>;

Outcome solve(const std::string& members) {
    EngineOptions options;
    options.device = DeviceChoice::native;
    return Engine(options).run(
        parse_job(R"({"integrator":"quadrature","diffuse":{"model":"ggx_lambert",)"
                  R"("albedo":[0.9,0.5,0.2]},"output":{"format":"exr","pixel":"float"},)" +
                  members + "}"),
        Control{});
}

const char* const kAxes =
    R"("resolution":[3,2],"layout":{"x":{"parameter":"NoV","range":[0.1,0.7]},)"
    R"("y":{"parameter":"roughness","range":[0.5,0.9]}})";
const Values kViews = {.2, .4, .6};
constexpr double kRoughnesses[] = {.6, .8};
constexpr double kAlbedos[] = {.9, .5, .2};

// 60 facets leave less than 1e-9 of the light at these roughnesses.
TEST(FacetJobs, DirectionalAndAverageAlbedos) {
    for (const auto& [precision, tolerance] : {std::pair{"float32", 5e-7}, {"float64", 6e-8}}) {
        const Outcome outcome =
            solve(std::string(
                      R"("quantities":["diffuse_albedo","diffuse_average_albedo"],"precision":")") +
                  precision + "\"," + kAxes);
        ASSERT_EQ(outcome.table.planes.size(), 6U);
        EXPECT_EQ(outcome.report.status, "converged");
        for (std::size_t row = 0; row < 2; ++row) {
            const double alpha = kRoughnesses[row] * kRoughnesses[row];
            const auto shares = reference::ggx_lambert_shares(alpha, kViews, 60);
            const auto average = reference::ggx_lambert_average_shares(alpha, 60);
            for (std::size_t c = 0; c < 3; ++c)
                for (std::size_t x = 0; x < 3; ++x) {
                    const std::size_t texel = 3 * row + x;
                    EXPECT_NEAR(outcome.table.planes[c][texel],
                                reference::ggx_lambert_albedo(shares[x], kAlbedos[c]), tolerance);
                    EXPECT_NEAR(outcome.table.planes[3 + c][texel],
                                reference::ggx_lambert_albedo(average, kAlbedos[c]), tolerance);
                }
        }
        for (const ChannelError& error : outcome.report.error)
            EXPECT_LE(error.reference_max.value_or(1), 1e-6) << error.quantity;
        EXPECT_GT(outcome.report.work.brdf_evaluations, 0U);
    }
}

// Under the coupling "view" a specular lobe is added, and what it reflects is taken from the walk:
// the same by samples, within their error.
TEST(FacetJobs, ASpecularLobeAboveThem) {
    const std::string rest = std::string(R"("quantities":["total_albedo"],"coupling":"view",)") +
                             R"("fresnel":{"model":"dielectric","ior":1.5},)" + kAxes;
    const Outcome exact = solve(rest);
    JobSpec job = parse_job(R"({"diffuse":{"model":"ggx_lambert","albedo":[0.9,0.5,0.2]},)"
                            R"("sample_count":65536,)" +
                            rest + "}");
    const Outcome sampled = bake(job);
    for (std::size_t c = 0; c < 3; ++c)
        for (std::size_t i = 0; i < 6; ++i)
            EXPECT_NEAR(exact.table.planes[c][i], sampled.table.planes[c][i],
                        5 * sampled.standard_errors[c][i] + 1e-6);
}

TEST(FacetJobs, SamplesAreHeldAgainstIt) {
    const Outcome outcome =
        bake(parse_job(R"({"quantities":["diffuse_albedo"],"diffuse":{"model":"ggx_lambert",)"
                       R"("albedo":0.8},"sample_count":4096,)" +
                       std::string(kAxes) + "}"));
    const ChannelError& error = outcome.report.error.at(0);
    ASSERT_TRUE(error.reference_max);
    EXPECT_GT(*error.reference_max, 0);
    EXPECT_LT(*error.reference_max, 5 * error.standard_error_max.value_or(0));
}

TEST(FacetAlbedos, AreInTheOrderOfTheirPlaces) {
    ThreadPool pool(2);
    const Values NoV = {.5, .1, .5, .1}, alpha = {.3, .3, .1, .1}, rhos = {.8, .4};
    const auto tolerance = [](double) { return 1e-6; };
    const FacetAlbedos all = facet_albedos({NoV, alpha, rhos}, pool, tolerance);
    ASSERT_EQ(all.of.size(), 2U);
    EXPECT_EQ(all.unsettled, 0U);
    for (std::size_t i = 0; i < 4; ++i) {
        const FacetAlbedos one = facet_albedos(
            {std::span(NoV).subspan(i, 1), std::span(alpha).subspan(i, 1), rhos}, pool, tolerance);
        for (std::size_t k = 0; k < 2; ++k) EXPECT_EQ(all.of[k][i], one.of[k][0]);
        EXPECT_LE(all.error[i], 1e-6f);
    }
    EXPECT_EQ(facet_albedos({NoV, alpha, rhos}, pool, [](double) { return 1e-14; }).unsettled, 4U);
    EXPECT_THROW(facet_albedos({NoV, alpha, rhos}, pool,
                               [](double) -> double { throw std::runtime_error("enough"); }),
                 std::runtime_error);
}

}  // namespace
}  // namespace kiln
