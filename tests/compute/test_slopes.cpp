// SPDX-License-Identifier: Apache-2.0
// How errors fall with the samples, and how far they get: figures N1, N2 and N9 of the accuracy
// that is promised for sampling.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "server/compute/points.h"
#include "server/spec/words.h"
#include "tests/compute/sampled_places.h"
#include "tests/reference/coupling_models.h"

namespace kiln {
namespace {

using namespace sampled_places;

constexpr int kSeeds = 32;

/// Root mean square errors over the seeds: [quantity][texel][doubling of the samples from 1024 on].
using Errors = std::vector<std::vector<std::vector<double>>>;

Errors errors_of(JobSpec job, const std::vector<Values>& truth, int doublings) {
    Errors errors(truth.size(), std::vector(truth[0].size(), std::vector<double>()));
    BakerOnBoth bake;
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

/// Slope of the errors from the level `first` on that are above what a float holds, over at least
/// four of them; else -10.
double slope_from(const std::vector<double>& errors, std::size_t first) {
    std::vector<double> fitted;
    for (std::size_t level = first; level < errors.size(); ++level)
        if (errors[level] > 3e-7) fitted.push_back(errors[level]);
    return fitted.size() < 4 ? -10 : log2_slope(fitted);
}

// The figure's range: 2^6 to 2^14 points a replicate. Over 2^6 to 2^11 the slopes are .08 flatter,
// since the horizon is still thinner than a stratum there.
constexpr int kDoublings = 9;

// A root mean square of 32 draws has a deviation of 1/8 = .18 of a log2; a slope over nine of them
// one of .18 / √60 = .023. The figure allows .05, two of these.
constexpr double kFitNoise = .05;

/// For a bound over fewer doublings: 2.5 deviations.
double fit_noise(std::size_t levels) {
    const auto n = static_cast<double>(levels);
    return 2.5 * .18 / std::sqrt(n * (n * n - 1) / 12);
}

struct Grid {
    Masking masking;
    std::int64_t nodes;
};

class DefaultSampler : public testing::TestWithParam<Grid> {};

// Figure N9: -.85 at every α, -1 from α = .25 on.
TEST_P(DefaultSampler, N9Slopes) {
    const std::int64_t nodes = GetParam().nodes;
    JobSpec job = grid_job({.01, 1, nodes}, {.01, 1, nodes}, 1024);
    job.masking = GetParam().masking;
    std::vector<Values> truth = truth_of(job);
    truth.pop_back();
    job.quantities.pop_back();
    const Places places = Places::directional(job);
    const Errors errors = errors_of(job, truth, kDoublings);
    double flattest = -10;
    for (std::size_t q = 0; q < errors.size(); ++q)
        for (std::size_t i = 0; i < places.count(); ++i) {
            const double bound = (places.alpha(i) >= .25 ? -1 : -.85) + kFitNoise;
            const double slope = slope_from(errors[q][i], 0);
            EXPECT_LE(slope, bound) << to_word(job.quantities[q]) << " at " << where(job, i);
            flattest = std::max(flattest, slope);
        }
    std::printf("flattest slope %.3f\n", flattest);
}

INSTANTIATE_TEST_SUITE_P(Slopes, DefaultSampler,
                         testing::Values(Grid{Masking::smith_correlated, 4},
                                         Grid{Masking::smith_separable, 3}),
                         [](const auto& made) { return std::string(to_word(made.param.masking)); });

// Where 1 − E is the product and small, log-uniform tangents have it: its error is a fiftieth of it
// from 2^11 points on and falls like that of a jump.
TEST(Slopes, OfTheDeficitByLogTangents) {
    constexpr int kLevels = 7;
    JobSpec job = grid_job({.1, 1, 3}, {.01, .0101, 1}, 1024);
    const std::vector<Values> truth = {truth_of(job)[3]};
    job.quantities = {Quantity::multiscatter_albedo};
    const Errors errors = errors_of(job, truth, kLevels);
    for (std::size_t i = 0; i < truth[0].size(); ++i) {
        EXPECT_LE(slope_from(errors[0][i], 0), -.75 + fit_noise(kLevels)) << where(job, i);
        EXPECT_LE(errors[0][i][5], .02 * truth[0][i]) << where(job, i);
    }
}

TEST(Slopes, N9PlainMonteCarlo) {
    // Eight levels have a deviation of .18 / √42 = .028, so the figure's ±.1 is 3.6 of them.
    JobSpec job = grid_job({.01, 1, 2}, {.1, 1, 2}, 1024);
    job.sampler = Sampler::random;
    const Errors errors = errors_of(job, truth_of(job), 8);
    for (std::size_t q = 0; q < 4; ++q)
        for (std::size_t i = 0; i < 4; ++i)
            EXPECT_NEAR(log2_slope(errors[q][i]), -.5, .1)
                << to_word(job.quantities[q]) << where(job, i);
}

// Light inside a denser medium: F has a kink where it is reflected totally. From 4096 samples on
// the sampler knows where (kernels/parted_lights.h); below, a net meets it with a slope of -3/4.
TEST(Slopes, N9TotalReflection) {
    JobSpec job = grid_job({.4, .9, 2}, {.05, 1, 2}, 1024);
    job.quantities = {Quantity::specular_albedo, Quantity::total_albedo};
    job.fresnel.model = Fresnel::dielectric;
    job.fresnel.ior = {1 / 1.5};
    job.coupling = Coupling::half_vector;
    job.diffuse.model = DiffuseModel::burley;
    const Places places = Places::directional(job);
    std::vector<Values> truth(2);
    for (std::size_t i = 0; i < places.count(); ++i) {
        const reference::Specular lobe{{reference::Distribution::ggx,
                                        reference::Visibility::smith_correlated, places.alpha(i)},
                                       reference::fresnel_dielectric(1 / 1.5)};
        const reference::Material material(
            reference::Coupling::half_vector, lobe,
            {reference::DiffuseModel::burley, std::sqrt(places.alpha(i)), job.diffuse.albedo[0]});
        truth[0].push_back(reference::SpecularAlbedo(lobe).at(places.NoV(i)));
        truth[1].push_back(material.total(places.NoV(i)));
    }
    constexpr int kFrom = 2;
    const Errors errors = errors_of(job, truth, kDoublings);
    double flattest = -10;
    for (std::size_t q = 0; q < truth.size(); ++q)
        for (std::size_t i = 0; i < places.count(); ++i) {
            const double slope = slope_from(errors[q][i], kFrom);
            EXPECT_LE(slope, -1.15 + fit_noise(kDoublings - kFrom))
                << to_word(job.quantities[q]) << " at " << where(job, i);
            flattest = std::max(flattest, slope);
        }
    std::printf("flattest slope %.3f\n", flattest);
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
    const Outcome outcome = BakerOnBoth()(job);
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
// in double (twice what a job may ask for), 5e-6 in float; 1024 in each of 16 replicates 4e-4.
constexpr Effort kMost{Precision::float64, 1 << 21, 2e-6},
    kMostFloat{Precision::float32, 1 << 21, 5e-6}, kFew{Precision::float32, 16384, 4e-4};

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
