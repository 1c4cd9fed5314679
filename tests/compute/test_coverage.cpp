// SPDX-License-Identifier: Apache-2.0
// How often the truth lies in the 95 % interval of a sampled value.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "server/compute/estimate.h"
#include "server/compute/native.h"
#include "server/spec/words.h"
#include "tests/compute/sampled_places.h"
#include "tests/reference/coupling_models.h"

namespace kiln {
namespace {

using namespace sampled_places;

constexpr int kTrials = 200;

struct Case {
    std::string name;
    Masking masking;
    Ends NoV, alpha;
    std::int64_t sample_count;
    bool deficit = true;  ///< without it, log-uniform tangents help no quantity
    Sampler sampler = Sampler::sobol_owen;
};

std::string name_of(const testing::TestParamInfo<Case>& info) { return info.param.name; }
void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

class Coverage : public testing::TestWithParam<Case> {};

/// How often the interval of 16 replicates holds the truth where they have this skewness and excess
/// kurtosis: Hall 1992, "The bootstrap and Edgeworth expansion", eq. 2.56, to the first order.
double coverage_of(double skewness, double kurtosis) {
    constexpr double t2 = kStudentT * kStudentT;
    const double q =
        kStudentT * (kurtosis / 12 * (t2 - 3) - skewness * skewness / 18 * (t2 * t2 + 2 * t2 - 3));
    const double density = std::exp(-t2 / 2) / std::sqrt(2 * std::numbers::pi);
    return 0.95 + 2 * q * density / kReplicatesMax;
}

/// Counts of trials binomially distributed stray so far once in a thousand cases.
double stray(double chance, int trials) { return 3.3 * std::sqrt(chance * (1 - chance) / trials); }

/// One texel of a case over many more seeds.
struct SecondLook {
    double coverage = 0, skewness = 0, kurtosis = 0;  ///< the latter two of one replicate
};

constexpr int kMoreTrials = 500;

SecondLook look_again(JobSpec job, std::size_t quantity, std::size_t texel) {
    const Places places = Places::directional(job);
    const double NoV = places.NoV(texel), alpha = places.alpha(texel);
    JobSpec one = grid_job({NoV, NoV + 1e-9, 1}, {alpha, alpha + 1e-9, 1}, job.sample_count);
    one.masking = job.masking;
    one.sampler = job.sampler;
    one.quantities = job.quantities;
    const double truth = truth_of(one)[quantity][0];
    SecondLook seen;
    std::vector<double> errors;
    BakerOnBoth bake;
    for (int trial = 0; trial < kMoreTrials; ++trial) {
        one.seed = static_cast<std::uint64_t>(trial) + 100000;
        const Outcome outcome = bake(one);
        errors.push_back(outcome.table.planes[quantity][0] - truth);
        seen.coverage +=
            (std::abs(errors.back()) <=
             kStudentT * outcome.standard_errors[quantity][0] + rounding_floor(job.precision)) /
            double{kMoreTrials};
    }
    double second = 0, third = 0, fourth = 0;
    for (const double e : errors) {
        second += e * e / kMoreTrials;
        third += e * e * e / kMoreTrials;
        fourth += e * e * e * e / kMoreTrials;
    }
    // A mean of 16 has a quarter of their skewness, a sixteenth of their kurtosis.
    seen.skewness = std::sqrt(kReplicatesMax) * third / std::pow(second, 1.5);
    seen.kurtosis = kReplicatesMax * (fourth / (second * second) - 3);
    return seen;
}

void hold_again(const JobSpec& job, std::size_t quantity, std::size_t texel) {
    const SecondLook seen = look_again(job, quantity, texel);
    const double expected = coverage_of(seen.skewness, seen.kurtosis);
    const std::string what(to_word(job.quantities[quantity]));
    std::printf("  %s at %s: %.3f, skewness %.2f, kurtosis %.1f: %.3f\n", what.c_str(),
                where(job, texel).c_str(), seen.coverage, seen.skewness, seen.kurtosis, expected);
    EXPECT_GE(seen.coverage, expected - stray(expected, kMoreTrials)) << where(job, texel);
    const double least = coverage_of(2, 2);
    EXPECT_GE(seen.coverage, least - stray(least, kMoreTrials)) << where(job, texel);
}

// Of a nominal 95 % of 200 trials, binomial noise alone makes 89.5 to 99 % (99.9 % of cases), and
// the pooled share is held to 92…99 %. What is below 88 % is looked at again in 500 trials: it
// may miss what the skewness of its replicates makes Student's interval miss, and noise, and no
// more than replicates as skewed as exponential variables, 2, would (88.8 %): where an edge cuts a
// point in two, some replicates count it and some do not. Where the interval is as wide as the
// rounding that belongs to it, no trial may miss, and such cases would push the pool above 99 %:
// they are left out of it. All trials of a case are independent, cases of one trial share their
// points.
TEST_P(Coverage, IsWhatTheStandardErrorPromises) {
    const Case& c = GetParam();
    JobSpec job = grid_job(c.NoV, c.alpha, c.sample_count);
    job.masking = c.masking;
    job.sampler = c.sampler;
    if (!c.deficit) job.quantities.pop_back();
    const std::vector<Values> truth = truth_of(job);
    const std::size_t quantities = job.quantities.size();
    std::vector<std::vector<int>> inside(quantities, std::vector<int>(truth[0].size())),
        wide = inside;
    BakerOnBoth bake;
    for (int trial = 0; trial < kTrials; ++trial) {
        job.seed = static_cast<std::uint64_t>(trial) + 1000;
        const Outcome outcome = bake(job);
        // By random points a B in twenty is off by more than its bound, which is suspect.
        if (c.sampler != Sampler::random) {
            EXPECT_EQ(outcome.report.status, "done");
        }
        for (std::size_t q = 0; q < quantities; ++q)
            for (std::size_t i = 0; i < truth[q].size(); ++i) {
                const double floor = rounding_floor(job.precision);
                const double half_width = kStudentT * outcome.standard_errors[q][i];
                const double error = std::abs(outcome.table.planes[q][i] - truth[q][i]);
                inside[q][i] += error <= half_width + floor;
                wide[q][i] += half_width > floor;
            }
    }
    double pooled = 0, count = 0;
    for (std::size_t q = 0; q < quantities; ++q) {
        double pooled_here = 0, count_here = 0;
        for (std::size_t i = 0; i < truth[q].size(); ++i) {
            if (inside[q][i] < kTrials * 88 / 100) hold_again(job, q, i);
            if (wide[q][i] < kTrials / 2) continue;
            pooled_here += inside[q][i];
            count_here += kTrials;
        }
        if (count_here > 0) {
            EXPECT_GE(pooled_here / count_here, 0.92) << to_word(job.quantities[q]);
        }
        pooled += pooled_here;
        count += count_here;
    }
    ASSERT_GT(count, 0);
    std::printf("%s: pooled %.4f of %g\n", c.name.c_str(), pooled / count, count);
    EXPECT_GE(pooled / count, 0.92);
    EXPECT_LE(pooled / count, 0.99);
}

// Figure N10: the whole grid, and the corner where α and NoV are small.
const Ends kAllNoV{1e-4, 1, 8}, kAllAlpha{1e-4, 1, 9}, kSmallNoV{1e-4, 0.02, 6},
    kSmallAlpha{1e-4, 0.02, 6};
// Where few lights along the horizon carry what B loses: .88 to .92 of bars held without them.
const Ends kFarBelow{3e-4, 3e-3, 4}, kRough{.2, 1, 5};
INSTANTIATE_TEST_SUITE_P(
    N10, Coverage,
    testing::Values(
        Case{"correlated_1024", Masking::smith_correlated, kAllNoV, kAllAlpha, 1024},
        Case{"correlated_4096", Masking::smith_correlated, kAllNoV, kAllAlpha, 4096},
        Case{"separable_1024", Masking::smith_separable, kAllNoV, kAllAlpha, 1024},
        Case{"separable_4096", Masking::smith_separable, kAllNoV, kAllAlpha, 4096},
        Case{"corner_1024", Masking::smith_correlated, kSmallNoV, kSmallAlpha, 1024},
        Case{"corner_16384", Masking::smith_correlated, kSmallNoV, kSmallAlpha, 16384},
        Case{"separable_corner_4096", Masking::smith_separable, kSmallNoV, kSmallAlpha, 4096},
        Case{"smooth_rows_1024", Masking::smith_correlated, {0.05, 1, 8}, {1e-4, 0.1, 6}, 1024},
        Case{"split_sum_1024", Masking::smith_correlated, kAllNoV, kAllAlpha, 1024, false},
        Case{"split_sum_4096", Masking::smith_correlated, kAllNoV, kAllAlpha, 4096, false},
        Case{
            "grazing_4096", Masking::smith_correlated, {1e-4, 2e-3, 5}, {3e-3, .3, 6}, 4096, false},
        Case{"far_below_1024", Masking::smith_correlated, kFarBelow, kRough, 1024, false},
        Case{"far_below_4096", Masking::smith_correlated, kFarBelow, kRough, 4096, false},
        Case{"far_below_16384", Masking::smith_correlated, kFarBelow, kRough, 16384, false},
        Case{"far_below_deficit_4096", Masking::smith_correlated, kFarBelow, kRough, 4096},
        Case{"far_below_random_4096", Masking::smith_correlated, kFarBelow, kRough, 4096, false,
             Sampler::random},
        Case{"random_1024", Masking::smith_correlated, kAllNoV, kAllAlpha, 1024, true,
             Sampler::random},
        Case{"random_4096", Masking::smith_correlated, kAllNoV, kAllAlpha, 4096, false,
             Sampler::random}),
    name_of);

// The other half of N10, at 32 replicates: two jobs of 16. Student's t with 30 degrees of freedom
// is above 5 once in 43000 draws.
TEST(CoverageOfAll, N10NoErrorIsAboveFiveStandardErrors) {
    BakerOnBoth bake;
    double most = 0;
    for (const Masking masking : {Masking::smith_correlated, Masking::smith_separable})
        for (const std::int64_t samples : {1024, 4096}) {
            JobSpec job = grid_job(kAllNoV, kAllAlpha, samples);
            job.masking = masking;
            const std::vector<Values> truth = truth_of(job);
            std::vector<Outcome> halves;
            for (job.seed = 1; job.seed <= 2; ++job.seed) halves.push_back(bake(job));
            for (std::size_t q = 0; q < truth.size(); ++q)
                for (std::size_t i = 0; i < truth[q].size(); ++i) {
                    const double value =
                        (halves[0].table.planes[q][i] + halves[1].table.planes[q][i]) / 2;
                    const double standard_error = std::hypot(halves[0].standard_errors[q][i],
                                                             halves[1].standard_errors[q][i]) /
                                                  2;
                    const double error = std::abs(value - truth[q][i]);
                    EXPECT_LE(error, 5 * standard_error + rounding_floor(job.precision))
                        << to_word(job.quantities[q]) << " at " << where(job, i);
                    if (error > rounding_floor(job.precision))
                        most = std::max(most,
                                        (error - rounding_floor(job.precision)) / standard_error);
                }
        }
    std::printf("largest error over standard error: %.2f\n", most);
}

/// E_avg of each place, at the precision's rounding of it.
Values truth_of_averages(const JobSpec& job) {
    ThreadPool pool(1);
    const auto native = make_native_backend(pool, usable_instruction_sets().front());
    const Places places = Places::averaged(job);
    Values truth;
    for (std::size_t i = 0; i < places.count(); ++i) {
        const bool narrow = job.precision == Precision::float32;
        const double alpha = narrow ? static_cast<float>(places.alpha(i)) : places.alpha(i);
        truth.push_back(1 - quadrature_averages(*native, quadrature_average_kind(lobe_of(job)), {},
                                                std::array{alpha}, 1e-9, [] {})
                                .mean[0]);
    }
    return truth;
}

JobSpec averages_job(const Ends& alpha, std::int64_t sample_count) {
    JobSpec job = grid_job({0, 1, 1}, alpha, sample_count);
    job.quantities = {Quantity::average_albedo};
    job.resolution = {alpha.count};
    job.axes = {job.axes[1]};
    return job;
}

/// Of 200 trials, how many hold the truth of a job's one quantity: at each place at least what
/// chance leaves of 95 %, all together 92 to 99 %.
class Held {
  public:
    void hold(JobSpec job, const Values& truth, const std::function<std::string(std::size_t)>& at) {
        std::vector<double> inside(truth.size());
        for (int trial = 0; trial < kTrials; ++trial) {
            job.seed = static_cast<std::uint64_t>(trial) + 1000;
            const Outcome outcome = bake_(job);
            for (std::size_t i = 0; i < truth.size(); ++i) {
                const double half_width = kStudentT * outcome.standard_errors[0][i];
                const double error = std::abs(outcome.table.planes[0][i] - truth[i]);
                inside[i] += error <= half_width + rounding_floor(job.precision);
            }
        }
        for (std::size_t i = 0; i < truth.size(); ++i) {
            EXPECT_GE(inside[i] / kTrials, .95 - stray(.95, kTrials))
                << to_word(job.sampler) << ' ' << job.sample_count << ' ' << at(i);
            pooled_ += inside[i];
            count_ += kTrials;
        }
    }

    void hold_pool(const char* name) const {
        std::printf("%s: pooled %.4f of %g\n", name, pooled_ / count_, count_);
        EXPECT_GE(pooled_ / count_, 0.92);
        EXPECT_LE(pooled_ / count_, 0.99);
    }

  private:
    BakerOnBoth bake_;
    double pooled_ = 0, count_ = 0;
};

// Averages from where rounding does not rule on: .83 to .88 without normals towards the horizon.
TEST(CoverageOfAverages, HoldsAtEveryAlpha) {
    Held held;
    for (const Sampler sampler : {Sampler::sobol_owen, Sampler::random})
        for (const Ends alpha : {Ends{.005, .014, 4}, Ends{.02, .5, 4}}) {
            JobSpec job = averages_job(alpha, 1024);
            job.sampler = sampler;
            held.hold(job, truth_of_averages(job), [&](std::size_t i) {
                return "alpha " + std::to_string(Places::averaged(job).alpha(i));
            });
        }
    held.hold_pool("averages");
}

// F has a kink where total reflection begins. From 4096 samples on the sampler draws the light of
// both sides apart (kernels/parted_lights.h), below it does not.
TEST(CoverageOfTotalReflection, HoldsAtEveryPlace) {
    JobSpec job = grid_job({.1, 1, 3}, {.05, 1, 3}, 1024);
    job.quantities = {Quantity::specular_albedo};
    job.fresnel.model = Fresnel::dielectric;
    job.fresnel.ior = {1 / 1.5};
    const Places places = Places::directional(job);
    Values truth;
    for (std::size_t i = 0; i < places.count(); ++i) {
        const reference::Specular lobe{
            {reference::Distribution::ggx, reference::Visibility::smith_correlated,
             static_cast<float>(places.alpha(i))},
            reference::fresnel_dielectric(1 / 1.5)};
        truth.push_back(reference::SpecularAlbedo(lobe).at(static_cast<float>(places.NoV(i))));
    }
    Held held;
    for (const Sampler sampler : {Sampler::sobol_owen, Sampler::random})
        for (const std::int64_t samples : {1024, 4096}) {
            job.sampler = sampler;
            job.sample_count = samples;
            held.hold(job, truth, [&](std::size_t i) { return where(job, i); });
        }
    held.hold_pool("total reflection");
}

// An average of a line at low roughness has the same rare events.
TEST(StiffDeficit, AveragesHaveItToo) {
    JobSpec job = averages_job({1e-3, .02, 4}, 16384);
    job.precision = Precision::float64;
    const Values truth = truth_of_averages(job);
    const Places places = Places::averaged(job);
    BakerOnBoth bake;
    for (int seed = 1; seed <= 16; ++seed) {
        job.seed = static_cast<std::uint64_t>(seed);
        const Outcome outcome = bake(job);
        for (std::size_t i = 0; i < truth.size(); ++i) {
            const double error = truth[i] - outcome.table.planes[0][i];
            const double bound = 6.2 * outcome.standard_errors[0][i] + 6e-8;
            EXPECT_LE(std::abs(error), bound) << places.alpha(i) << " seed " << seed;
            // A root mean square of .0076 to .0097 over 400 seeds, and four deviations of a spread
            // of 16; by log-uniform tangents .05 to .06.
            EXPECT_LE(outcome.standard_errors[0][i], 0.017 * (1 - truth[i])) << places.alpha(i);
        }
    }
}

}  // namespace
}  // namespace kiln
