// SPDX-License-Identifier: Apache-2.0
#include "server/compute/facet_space.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "tests/reference/ggx_lambert.h"

// Lambertian GGX facets without chance, beside sums over orders of another rule, and one bounce by
// the integral over its normals.
namespace kiln {
namespace {

using Values = std::vector<double>;

constexpr std::array kAlphas = {1e-4, 1e-3, .01, .03, .1, .3, .7, 1.};
const Values kViews = {1e-4, 1e-3, .01, .03, .1, .2, .5, .8, 1};

std::vector<FacetSpace::Lit> lights_of(const FacetSpace& space, const Values& rhos) {
    std::vector<FacetSpace::Lit> lights;
    for (const double rho : rhos) lights.push_back(space.lit(rho));
    return lights;
}

TEST(FacetSpace, AgreesWithSumsOverOrders) {
    const Values rhos = {.95, .8, .3}, views = {.1, .2, .5, .8, 1};
    for (const double alpha : {.1, .3, .7, 1.}) {
        const FacetSpace space(alpha, 48);
        const auto lights = lights_of(space, rhos);
        // 60 facets leave 1e-9 at alpha .68, 2e-8 of (.95)^60 at 1.
        const auto shares = reference::ggx_lambert_shares(alpha, views, 60, 48);
        const auto average = reference::ggx_lambert_average_shares(alpha, 60, 48);
        for (std::size_t k = 0; k < rhos.size(); ++k) {
            for (std::size_t v = 0; v < views.size(); ++v)
                EXPECT_NEAR(space.albedo(views[v], lights)[k],
                            reference::ggx_lambert_albedo(shares[v], rhos[k]), 1e-8)
                    << alpha << ' ' << views[v] << ' ' << rhos[k];
            EXPECT_NEAR(space.average(lights[k]), reference::ggx_lambert_albedo(average, rhos[k]),
                        1e-8)
                << alpha << ' ' << rhos[k];
        }
    }
}

// Where nearly nothing is reflected the first facet has it all; what the second adds is 1e-10.
TEST(FacetSpace, OneBounceIsTheIntegralOverNormals) {
    for (const double alpha : {1e-3, .01, .1, .5, 1.}) {
        const FacetSpace space(alpha, 48);
        const auto lights = lights_of(space, {1e-10});
        for (const double NoV : {1e-4, 1e-3, .01, .1, .5, 1.})
            EXPECT_NEAR(space.albedo(NoV, lights)[0] / 1e-10,
                        reference::ggx_lambert_single_albedo(alpha, NoV), 4e-9)
                << alpha << ' ' << NoV;
    }
}

TEST(FacetSpace, WhiteFacetsLoseNothing) {
    for (const double alpha : kAlphas) {
        const FacetSpace space(alpha, 16);
        const auto lights = lights_of(space, {1});
        for (const double NoV : kViews)
            EXPECT_NEAR(space.albedo(NoV, lights)[0], 1, 1e-13) << alpha << ' ' << NoV;
        EXPECT_NEAR(space.average(lights[0]), 1, 1e-8) << alpha;
    }
}

// Against twice the directions; the figures of the header.
TEST(FacetSpace, RulesConverge) {
    const std::pair<unsigned, double> rules[] = {{16, 3e-6}, {24, 5e-7}, {32, 2e-8}, {48, 1e-9}};
    for (const double alpha : kAlphas) {
        const FacetSpace fine(alpha, 96);
        const auto truth = lights_of(fine, {.8, .3});
        for (const auto& [directions, error] : rules) {
            const FacetSpace space(alpha, directions);
            const auto lights = lights_of(space, {.8, .3});
            double most = 0;
            for (const double NoV : kViews)
                for (std::size_t k = 0; k < 2; ++k)
                    most = std::max(
                        most, std::abs(space.albedo(NoV, lights)[k] - fine.albedo(NoV, truth)[k]));
            EXPECT_LT(most, error) << alpha << ' ' << directions;
        }
    }
}

TEST(FacetSpace, EndsAreLimits) {
    for (const double alpha : {0., 1e-12, 1e-8}) {
        const FacetSpace space(alpha, 16);
        const auto lights = lights_of(space, {.8});
        EXPECT_NEAR(space.albedo(.3, lights)[0], .8, 1e-8) << alpha;
        EXPECT_NEAR(space.average(lights[0]), .8, 1e-6) << alpha;
    }
    const FacetSpace space(.5, 48);
    const auto lights = lights_of(space, {.8});
    EXPECT_NEAR(space.albedo(0, lights)[0], space.albedo(1e-9, lights)[0], 1e-8);
}

}  // namespace
}  // namespace kiln
