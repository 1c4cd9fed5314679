// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <vector>

#include "server/compute/one_lane.h"
#include "server/spec/words.h"
#include "tests/compute/models.h"
#include "tests/reference/ggx_lambert.h"

// ggx_lambert: walks over Lambertian GGX facets, beside what invariance says of them.
namespace kiln {
namespace {

using namespace models;

// 60 facets leave 1e-9 of the light at roughness .825.
constexpr int kFacets = 60;

JobSpec simulated(std::vector<Quantity> quantities, std::vector<double> albedo) {
    JobSpec job = model_job(std::move(quantities));
    job.diffuse.model = DiffuseModel::ggx_lambert;
    job.diffuse.albedo = std::move(albedo);
    return job;
}

/// The reference at every texel, for any albedo.
class Truth {
  public:
    explicit Truth(const JobSpec& job) {
        for (const double roughness : roughnesses(job)) {
            const double alpha = roughness * roughness;
            const Values views = against_reference::positions(job.axes[0], job.resolution[0]);
            for (const auto& shares : reference::ggx_lambert_shares(alpha, views, kFacets))
                directional_.push_back(shares);
            average_.insert(average_.end(), views.size(),
                            reference::ggx_lambert_average_shares(alpha, kFacets));
        }
    }
    Values directional(double albedo) const { return of(directional_, albedo); }
    Values average(double albedo) const { return of(average_, albedo); }

  private:
    static Values of(const std::vector<Values>& shares, double albedo) {
        Values values;
        for (const Values& one : shares)
            values.push_back(reference::ggx_lambert_albedo(one, albedo));
        return values;
    }
    std::vector<Values> directional_, average_;
};

// What the kernel's end of a walk leaves out, at every albedo: most where all is rough and nearly
// white. At albedo 1 it is nothing.
TEST(Simulated, AWalksEndIsBounded) {
    constexpr std::ptrdiff_t kWalked = KILN_WALK_FACETS;
    constexpr double kLeaving = KILN_WALK_LEAVING;
    double most = 0;
    for (const double alpha : {.3, .5, .7, .8, .85, .9, .95, 1.})
        for (const Values& shares :
             reference::ggx_lambert_shares(alpha, {.01, .1, .3, .6, 1}, kFacets, 24)) {
            const Values later(shares.begin() + kWalked, shares.end());
            const double rest = std::accumulate(later.begin(), later.end(), 0.0);
            for (double rho = .02; rho < .999; rho += .02) {
                const double assumed = rest * rho * kLeaving / (1 - (1 - kLeaving) * rho);
                const double truth = reference::ggx_lambert_albedo(later, rho);
                most = std::max(most, std::pow(rho, kWalked) * std::abs(assumed - truth));
            }
        }
    EXPECT_LT(most, 1.5e-6);
    EXPECT_GT(most, 5e-7);  // else walks could be shorter
}

// A walk has 45 dimensions, of which a net serves the first 15 and permutations of it the others:
// what facets make together beyond the fifth falls as plain Monte Carlo does. Largest standard
// errors at albedo .8, of the table and of its averages: 1.8e-6 at 2^20 samples and 8.8e-7 at 2^21,
// so that kExact is more than five of them there; at albedo .3, 3.4e-7 and 2.4e-7. At albedo 1 and
// 0 nothing is left to chance.
TEST(Simulated, AgreesWithInvariance) {
    const std::vector<double> albedos = {1, 0.8, 0.3};
    JobSpec job = simulated({Quantity::diffuse_albedo, Quantity::diffuse_average_albedo}, albedos);
    const Truth truth(job);
    const Outcome outcome = bake(job);
    ASSERT_EQ(outcome.table.planes.size(), 6U);
    for (std::size_t c = 0; c < 3; ++c) {
        hold(outcome, c, truth.directional(albedos[c]), "ggx_lambert");
        hold(outcome, 3 + c, truth.average(albedos[c]), "ggx_lambert");
    }
}

TEST(Simulated, EverySamplerConvergesToTheSame) {
    for (const Sampler sampler : {Sampler::hammersley, Sampler::lattice, Sampler::random}) {
        JobSpec job = simulated({Quantity::diffuse_albedo}, {0.7});
        job.sampler = sampler;
        job.sample_count = samples() / 16;
        // Plain Monte Carlo: .1 / 2^8 = 4e-4 a standard error.
        const Outcome outcome = bake(job);
        hold(outcome, 0, Truth(job).directional(0.7), std::string(to_word(sampler)), 2e-3);
        // Where the points of a batch do not fill the cube, facets repeat each other's azimuths,
        // and the shifts of a lattice then differ by 2.5e-4 at any number of points.
        if (sampler == Sampler::random) continue;
        for (const float error : outcome.standard_errors[0]) EXPECT_LT(error, 1.5e-4f);
    }
}

TEST(Simulated, SmoothIsLambertAndBlackIsBlack) {
    JobSpec job = simulated({Quantity::diffuse_albedo}, {0.6, 0, 1});
    job.axes[0].lo = 0, job.axes[1].lo = 0;
    job.axes[0].grid = Grid::node, job.axes[1].grid = Grid::node;
    job.sample_count = 256;
    const Table table = bake(job).table;
    for (std::size_t texel = 0; texel < 8; ++texel) {
        if (texel < 4) {
            EXPECT_NEAR(table.planes[0][texel], 0.6, 1e-6) << texel;
        }
        EXPECT_EQ(table.planes[1][texel], 0) << texel;
        EXPECT_NEAR(table.planes[2][texel], 1, 2e-6) << texel;
    }
}

// A job of one albedo, three times, or slices of a launch: the walks are the same.
TEST(Simulated, ColoursShareTheirWalks) {
    JobSpec one = simulated({Quantity::diffuse_albedo}, {0.4});
    one.sample_count = 1000;
    JobSpec three = one;
    three.diffuse.albedo = {0.9, 0.4, 0.1};
    const Outcome a = bake(one), b = bake(three);
    EXPECT_EQ(a.table.planes[0], b.table.planes[1]);
    EXPECT_EQ(a.report.work.brdf_evaluations, b.report.work.brdf_evaluations);
}

// The walk's part decides: standard errors of 2.7e-6 at 2^17 samples, 9.3e-6 seen, and of 5.3e-7 at
// 2^20, 2.5e-7 seen.
TEST(Simulated, UnderASpecularLobe) {
    const auto F = reference::fresnel_dielectric(1.5);
    JobSpec job = simulated({Quantity::total_albedo}, {0.5});
    job.sample_count = few_samples();
    job.fresnel.model = Fresnel::dielectric;
    const Values diffuse = Truth(job).directional(0.5);
    for (const Coupling coupling : {Coupling::none, Coupling::view}) {
        job.coupling = coupling;
        std::size_t texel = 0;
        const Values truth = over_texels(job, [&](double NoV, double roughness) {
            const reference::Microfacet lobe{reference::Distribution::ggx,
                                             reference::Visibility::smith_correlated,
                                             roughness * roughness};
            const double walked = diffuse[texel++], share = F.at(NoV);
            return coupling == Coupling::view
                       ? share * reference::microfacet_albedo(lobe, NoV) + (1 - share) * walked
                       : reference::microfacet_albedo(lobe, NoV, F) + walked;
        });
        hold(bake(job), 0, truth, std::string(to_word(coupling)), long_form() ? kExact : 2e-5);
    }
}

}  // namespace
}  // namespace kiln
