// SPDX-License-Identifier: Apache-2.0
// How errors fall with the samples, and how far they get: figures N1, N2 and N9 of the accuracy
// that is promised for sampling.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "server/compute/region.h"
#include "server/spec/words.h"
#include "tests/compute/sampled_places.h"
#include "tests/reference/microfacet_albedo.h"

namespace kiln {
namespace {

using namespace sampled_places;

constexpr int kSeeds = 32;

/// Root mean square errors over the seeds: [quantity][texel][doubling of the samples from 1024 on].
using Errors = std::vector<std::vector<std::vector<double>>>;

Errors errors_of(JobSpec job, const std::vector<Values>& truth, int doublings) {
    Errors errors(truth.size(), std::vector(truth[0].size(), std::vector<double>()));
    Baker bake;
    for (int level = 0; level < doublings; ++level) {
        job.sample_count = 1024 << level;
        for (auto& quantity : errors)
            for (auto& texel : quantity) texel.push_back(0);
        for (int seed = 1; seed <= kSeeds; ++seed) {
            job.seed = static_cast<std::uint64_t>(seed);
            const Outcome outcome = bake(job);
            for (std::size_t q = 0; q < truth.size(); ++q)
                for (std::size_t i = 0; i < truth[q].size(); ++i) {
                    const double error = outcome.table.planes[q][i] - truth[q][i];
                    errors[q][i].back() += error * error / kSeeds;
                }
        }
    }
    for (auto& quantity : errors)
        for (auto& texel : quantity)
            for (double& error : texel) error = std::sqrt(error);
    return errors;
}

/// Whether log-uniform tangents have a place's deficit.
std::vector<bool> log_tangents(const JobSpec& job) {
    ThreadPool pool(1);
    const Plan plan = make_plan(job, [] { return Averages{}; });
    std::vector<bool> has(plan.passes.at(0).places.count());
    for (const Region& region : regions_of(plan.passes[0], pool))
        for (const std::uint32_t place : region.places) has[place] = region.log_tangents;
    return has;
}

/// Largest slope over the quantities and the texels of `which`, of errors that are above what a
/// float holds.
double slope_max(const JobSpec& job, const Errors& errors, const std::vector<bool>& which) {
    double most = -10;
    std::string at;
    for (std::size_t q = 0; q < errors.size(); ++q)
        for (std::size_t i = 0; i < errors[q].size(); ++i) {
            std::vector<double> fitted;
            for (const double error : errors[q][i])
                if (error > 1.5e-7) fitted.push_back(error);
            if (!which[i] || fitted.size() < 4) continue;
            const double slope = log2_slope(fitted);
            if (slope <= most) continue;
            most = slope;
            at = std::string(to_word(job.quantities[q])) + " at " + where(job, i);
        }
    std::printf("largest slope %.3f: %s\n", most, at.c_str());
    return most;
}

// A root mean square of 32 draws has a deviation of 1/8 = .18 of a log2, a slope over six of them
// one of .18 / √17.5 = .043, the largest of some hundred slopes lies 2.5 of these above.
constexpr double kFitNoise = .11;

class DefaultSampler : public testing::TestWithParam<Masking> {};

// Figure N9: -.85 where NoV, α >= .01, by visible normals. -1 of E where α >= .25; B, whose Fresnel
// term is steep at the horizon, stays at -.85. Where 1 - E is that small that log-uniform tangents
// have it, its error is a twentieth from the start, and falls like that of a jump along a curve in
// two dimensions, in theory by -3/4.
TEST_P(DefaultSampler, N9Slopes) {
    JobSpec job = grid_job({.01, 1, 5}, {.01, 1, 5}, 1024);
    job.masking = GetParam();
    const Places places = Places::directional(job);
    const std::vector<bool> by_log = log_tangents(job);
    std::vector<bool> by_vndf, rough;
    for (std::size_t i = 0; i < by_log.size(); ++i) {
        by_vndf.push_back(!by_log[i]);
        rough.push_back(!by_log[i] && places.alpha(i) >= .25);
    }
    const std::vector<Values> truth = truth_of(job);
    const Errors errors = errors_of(job, truth, 6);
    EXPECT_LE(slope_max(job, errors, by_vndf), -.85 + kFitNoise);
    EXPECT_LE(slope_max(job, {{}, {}, errors[2], errors[3]}, rough), -1 + kFitNoise);
    EXPECT_LE(slope_max(job, errors, by_log), -.75 + kFitNoise);
    for (std::size_t i = 0; i < by_log.size(); ++i)
        if (by_log[i]) {
            EXPECT_LE(errors[3][i].back(), .02 * truth[3][i]) << where(job, i);
        }
}

INSTANTIATE_TEST_SUITE_P(Slopes, DefaultSampler,
                         testing::Values(Masking::smith_correlated, Masking::smith_separable),
                         [](const auto& made) { return std::string(to_word(made.param)); });

TEST(Slopes, N9PlainMonteCarlo) {
    JobSpec job = grid_job({.01, 1, 3}, {.1, 1, 3}, 1024);
    job.sampler = Sampler::random;
    const Errors errors = errors_of(job, truth_of(job), 6);
    for (std::size_t q = 0; q < 4; ++q)
        for (std::size_t i = 0; i < 9; ++i)
            EXPECT_NEAR(log2_slope(errors[q][i]), -.5, kFitNoise + .02)
                << to_word(job.quantities[q]) << where(job, i);
}

// Light inside a denser medium: F has a kink where it is reflected totally.
TEST(Slopes, N9TotalReflection) {
    JobSpec job = grid_job({.1, .9, 3}, {.05, 1, 3}, 1024);
    job.quantities = {Quantity::specular_albedo};
    job.fresnel.model = Fresnel::dielectric;
    job.fresnel.ior = {1 / 1.5};
    const Places places = Places::directional(job);
    Values truth;
    for (std::size_t i = 0; i < places.count(); ++i)
        truth.push_back(
            reference::microfacet_albedo({reference::Distribution::ggx,
                                          reference::Visibility::smith_correlated, places.alpha(i)},
                                         places.NoV(i), reference::fresnel_dielectric(1 / 1.5)));
    const std::vector<bool> all(places.count(), true);
    EXPECT_LE(slope_max(job, errors_of(job, {truth}, 6), all), -.8 + kFitNoise);
}

struct Effort {
    Precision precision;
    std::int64_t sample_count;
    double error_max;
};

/// Largest error of any quantity at any place, and of 1 − E relative to it.
void hold(JobSpec job, const Effort& effort, const char* name) {
    job.precision = effort.precision;
    job.sample_count = effort.sample_count;
    const std::vector<Values> truth = truth_of(job);
    const Outcome outcome = Baker()(job);
    double most = 0;
    for (std::size_t q = 0; q < 4; ++q)
        for (std::size_t i = 0; i < truth[q].size(); ++i) {
            const double error = std::abs(outcome.table.planes[q][i] - truth[q][i]);
            most = std::max(most, error);
            EXPECT_LE(error, effort.error_max)
                << name << ' ' << to_word(job.quantities[q]) << " at " << where(job, i);
        }
    std::printf("%s: largest error %.2e\n", name, most);
}

// Figures N1 and N2: the grid, and places off it. 2^18 samples in each of 8 replicates reach 2e-6
// (in float 5e-6); 2^16 in each of 16, which is the most that a job may ask for, are half as many:
// 2^.9 as far. 1024 samples in each of 16 replicates: 4e-4.
constexpr Effort kMost{Precision::float64, 1 << 20, 4e-6},
    kMostFloat{Precision::float32, 1 << 20, 5e-6}, kFew{Precision::float32, 16384, 4e-4};

TEST(SampledValues, N1Grid) {
    for (const Masking masking : {Masking::smith_correlated, Masking::smith_separable}) {
        JobSpec job = grid_job({1e-4, 1, 5}, {1e-4, 1, 5}, 1);
        job.masking = masking;
        hold(job, kMost, "grid, float64");
        hold(job, kMostFloat, "grid, float32");
        job = grid_job({1e-4, 1, 8}, {1e-4, 1, 9}, 1);
        job.masking = masking;
        hold(job, kFew, "grid, 16384 samples");
    }
}

TEST(SampledValues, N2OffTheGrid) {
    JobSpec job = grid_job({.0137, .973, 4}, {.0021, .883, 4}, 1);
    hold(job, kMost, "off the grid, float64");
    job = grid_job({.00137, .973, 14}, {.00021, .883, 15}, 1);
    hold(job, kFew, "off the grid, 16384 samples");
}

}  // namespace
}  // namespace kiln
