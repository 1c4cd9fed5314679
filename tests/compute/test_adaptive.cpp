// SPDX-License-Identifier: Apache-2.0
// Jobs that stop by themselves: where, at which bits, and what they say about it.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "server/base/error.h"
#include "server/compute/stopping.h"
#include "server/spec/spec.h"
#include "server/spec/words.h"
#include "tests/compute/sampled_places.h"

namespace kiln {
namespace {

using namespace sampled_places;

JobSpec parsed(const std::string& fields) {
    JobSpec job = parse_job(R"({"resolution":[24,24],"quantities":["split_sum_scale",)"
                            R"("split_sum_bias"],)" +
                            fields + "}");
    job.device = DeviceChoice::native;
    return job;
}

const std::string kFloats = R"("output":{"pixel":"float"})";

bool says(const std::vector<std::string>& warnings, const std::string& part) {
    return std::any_of(warnings.begin(), warnings.end(), [&](const std::string& warning) {
        return warning.find(part) != std::string::npos;
    });
}

bool leaves_out(const Report& report, const std::string& what) {
    return std::any_of(report.left_out.begin(), report.left_out.end(),
                       [&](const LeftOut& entry) { return entry.what.find(what) == 0; });
}

// Each texel of a job that stops by itself is that of a job of so many samples, bit for bit:
// whatever its neighbours did, and wherever it stood in the packed launches. Which number it was
// shows in the bits; all together they are what the report says that it cost.
// At low roughness a job that may take 4096 samples has another sampler than one that may not.
TEST(Adaptive, ATexelsBitsAreThoseOfAJobWithItsSamples) {
    const std::string rough =
        R"("layout":{"x":{"parameter":"NoV"},"y":{"parameter":"alpha","range":[0.5,1]}},)";
    for (const char* sampler : {"sobol_owen", "random", "hammersley", "lattice"}) {
        SCOPED_TRACE(sampler);
        const std::string recipe =
            std::string(R"("sampler":")") + sampler + "\"," + rough + kFloats;
        JobSpec job = parsed(recipe + R"(,"target_error":1.5e-3,"sample_count":16384)");
        if (job.sampler == Sampler::random) job.target_error = 2e-2;
        const Outcome adaptive = Baker()(job);
        const std::size_t texels = adaptive.table.planes[0].size();
        std::vector<std::int64_t> stopped(texels, 0);
        std::uint64_t samples = 0;
        std::set<std::int64_t> levels;
        for (std::int64_t count = 1024; count <= 16384; count *= 2) {
            JobSpec fixed = job;
            fixed.target_error.reset();
            fixed.sample_count = count;
            const Outcome whole = Baker()(fixed);
            for (std::size_t i = 0; i < texels; ++i) {
                const auto equal = [&](const auto& a, const auto& b) {
                    return a[0][i] == b[0][i] && a[1][i] == b[1][i];
                };
                // A value may come twice where it hardly varies; its error does not.
                if (!equal(adaptive.table.planes, whole.table.planes) ||
                    !equal(adaptive.standard_errors, whole.standard_errors))
                    continue;
                stopped[i] = count;
                levels.insert(count);
                samples +=
                    static_cast<std::uint64_t>(is_nested(job.sampler) ? count : 2 * count - 1024);
            }
        }
        EXPECT_EQ(std::count(stopped.begin(), stopped.end(), 0), 0);
        EXPECT_EQ(stopped.size() > 0 ? *levels.rbegin() : 0, adaptive.report.samples_per_texel);
        EXPECT_GE(levels.size(), 2u) << "texels should differ";
        EXPECT_GE(*levels.begin(), 2048) << "two levels in a row";
        EXPECT_EQ(samples, adaptive.report.samples_total);
    }
}

// A bound of 95 % at two levels in a row: at most one run in a hundred ends in error.
TEST(Adaptive, ConvergedMeansWithinTheTarget) {
    JobSpec job = grid_job({1e-3, 1, 10}, {1e-4, 1, 10}, 1 << 20);
    const std::vector<Values> truth = truth_of(job);
    for (const double target : {1e-2, 1e-3, 1e-4}) {
        job.target_error = target;
        int beyond = 0, count = 0;
        for (int seed = 1; seed <= (target < 1e-3 ? 2 : 10); ++seed) {
            job.seed = static_cast<std::uint64_t>(seed);
            const Outcome outcome = Baker()(job);
            EXPECT_EQ(outcome.report.status, "converged") << target;
            EXPECT_TRUE(outcome.report.warnings.empty());
            for (std::size_t q = 0; q < 4; ++q)
                for (std::size_t i = 0; i < truth[q].size(); ++i) {
                    const double error = std::abs(outcome.table.planes[q][i] - truth[q][i]);
                    beyond += error > target;
                    EXPECT_LE(error, 2 * target) << where(job, i);
                    EXPECT_LE(kStudentT * outcome.standard_errors[q][i], target);
                    ++count;
                }
        }
        EXPECT_LE(beyond, count / 100) << target;
    }
}

TEST(Adaptive, AFinerTargetTakesMoreAndNeverRaisesTheError) {
    std::uint64_t before = 0;
    double error_before = 1;
    for (const double target : {1e-2, 3e-3, 1e-3, 3e-4}) {
        JobSpec job = parsed(kFloats);
        job.target_error = target;
        job.sample_count = 1 << 18;
        const Outcome outcome = Baker()(job);
        EXPECT_EQ(outcome.report.status, "converged");
        EXPECT_GT(outcome.report.samples_total, before);
        const double error = *outcome.report.error[0].standard_error_max;
        EXPECT_LE(error, error_before);
        EXPECT_LE(error * kStudentT, target);
        before = outcome.report.samples_total;
        error_before = error;
    }
}

// Figure N18: a trace is of all texels, also of those that have stopped.
TEST(Adaptive, N18DoublingNeverRaisesTheErrorOfTheTrace) {
    const Outcome outcome = Baker()(parsed(R"("target_error":5e-4,)" + kFloats));
    const auto& trace = outcome.report.trace;
    ASSERT_GE(trace.size(), 4u);
    for (std::size_t row = 1; row < trace.size(); ++row) {
        EXPECT_EQ(trace[row].sample_count, 2 * trace[row - 1].sample_count);
        EXPECT_GE(trace[row].elapsed_s, trace[row - 1].elapsed_s);
        EXPECT_LE(*trace[row].standard_error_rms, *trace[row - 1].standard_error_rms);
    }
    EXPECT_NEAR(*trace.back().standard_error_max,
                std::max(*outcome.report.error[0].standard_error_max,
                         *outcome.report.error[1].standard_error_max),
                1e-12);
}

TEST(Adaptive, SaysThatSampleCountEndedIt) {
    const Outcome outcome =
        Baker()(parsed(R"("target_error":1e-4,"sample_count":2048,"layout":{"x":)"
                       R"({"parameter":"NoV","range":[0.3,1]},"y":)"
                       R"({"parameter":"alpha","range":[0.3,1]}},)" +
                       kFloats));
    EXPECT_EQ(outcome.report.status, "budget_exhausted");
    EXPECT_TRUE(says(outcome.report.warnings, "sample_count ended the sampling before"));
    EXPECT_EQ(outcome.report.samples_per_texel, 2048);
}

TEST(Adaptive, SaysThatTimeEndedIt) {
    JobSpec job = parsed(R"("time_budget_s":0.001,)" + kFloats);
    job.resolution = {128, 128};
    const Outcome outcome = Baker()(job);
    const Report& report = outcome.report;
    EXPECT_EQ(report.status, "budget_exhausted");
    EXPECT_TRUE(says(report.warnings, "time_budget_s ended the sampling"));
    EXPECT_GE(report.samples_per_texel, 64);
    EXPECT_LT(report.samples_per_texel, job.sample_count);
    EXPECT_GE(report.samples_total, 64u * 128 * 128);
    for (const float value : outcome.table.planes[0]) EXPECT_GT(value, 0);
    // With time to spare it ends at sample_count, and nothing was asked for that it did not reach.
    job = parsed(R"("time_budget_s":3600,"sample_count":256,)" + kFloats);
    EXPECT_EQ(Baker()(job).report.status, "done");
    job.target_error = 0.5;
    job.sample_count = 1 << 18;
    const Outcome coarse = Baker()(job);
    EXPECT_EQ(coarse.report.status, "converged");
    EXPECT_EQ(coarse.report.samples_per_texel, 4096) << "256 points a replicate below alpha 0.1";
}

/// Of a run whose time is over while its progress is told after so many launches beyond each
/// place's first samples: launches beyond those, and how many of them began too late.
struct TimedLaunches {
    Report report;
    int first = 0, beyond = 0, begun_late = 0;
};

TimedLaunches run_out_of_time(const JobSpec& job, std::optional<int> over_after) {
    using Clock = std::chrono::steady_clock;
    const double first_part = 1 / static_cast<double>(level_samples(job).size()) + 1e-9;
    TimedLaunches found;
    std::optional<Clock::time_point> end;
    bool over = false;
    Control control;
    control.progress = [&](const Progress& progress) {
        if (!(progress.fraction > 0) || progress.fraction == 1) return;  // no launch
        // The engine's time began before its first word.
        if (!end) end = Clock::now() + std::chrono::milliseconds(200);
        const bool beyond = progress.fraction > first_part;
        ++(beyond ? found.beyond : found.first);
        found.begun_late += beyond && over;
        if (found.beyond == over_after) std::this_thread::sleep_until(*end);
        over = Clock::now() >= *end;
    };
    EngineOptions options;
    options.device = DeviceChoice::native;
    found.report = Engine(options).run(job, control).report;
    return found;
}

// Figure N18: a limit of time is kept to a launch, some milliseconds. Launches are counted, not
// seconds: none begins once the time is over, however slow the machine. The first samples of all
// places are taken in any case.
TEST(Adaptive, N18BeginsNoLaunchOnceItsTimeIsOver) {
    JobSpec job = parsed(R"("time_budget_s":0.2,"sample_count":1048576,)" + kFloats);
    job.resolution = {256, 256};
    // Of roughness: below, places of another sampler have a time of their own.
    job.axes[1].lo = .75;
    for (const std::optional<int> over_after : {std::optional<int>{}, {0}, {1}, {5}}) {
        const TimedLaunches found = run_out_of_time(job, over_after);
        SCOPED_TRACE(testing::Message()
                     << found.first << " first launches, " << found.beyond << " beyond, "
                     << found.report.samples_per_texel << " samples a texel");
        EXPECT_EQ(found.report.status, "budget_exhausted");
        EXPECT_GE(found.first, 1);
        EXPECT_EQ(found.begun_late, 0);
        EXPECT_LE(found.beyond, over_after.value_or(found.beyond));
        EXPECT_TRUE(over_after != 0 || found.report.samples_per_texel == 64);
    }
}

TEST(Adaptive, StopsAtRoundingAndSaysSo) {
    JobSpec job = parsed(R"("target_error":1e-7,"sample_count":1048576,)" + kFloats);
    job.quantities = {Quantity::directional_albedo};
    job.resolution = {2, 2};
    for (Axis& axis : job.axes) axis.lo = .9;
    const Outcome outcome = Baker()(job);
    EXPECT_EQ(outcome.report.status, "roundoff_floor");
    EXPECT_TRUE(says(outcome.report.warnings, "below what rounding leaves"));
    job.target_error = 1e-5;
    EXPECT_EQ(Baker()(job).report.status, "converged");
    // A mirror has no variance at all.
    job.axes[1].lo = 0;
    job.axes[1].hi = 1e-300;
    EXPECT_EQ(Baker()(job).report.status, "converged");
    job.target_error = 1e-7;
    EXPECT_EQ(Baker()(job).report.status, "roundoff_floor");
}

// A step of half in [.5, 1) is 2^-11, of 16-bit PNG 1 / 65535, of 8-bit 1 / 255.
TEST(Adaptive, StopsAtAQuarterOfWhatPixelsResolve) {
    const std::string target = R"("target_error":1e-5,"output":)";
    JobSpec job = parsed(target + R"({"pixel":"half"})");
    job.axes[1].lo = 0.3;  // below, the few rare events of E forbid to say "converged"
    const Outcome half = Baker()(job);
    EXPECT_EQ(half.report.status, "converged");
    EXPECT_TRUE(leaves_out(half.report, "sampling below a quarter of the pixel's quantum"));
    EXPECT_LE(kStudentT * *half.report.error[0].standard_error_max, std::exp2(-13));
    const Outcome eight = Baker()(parsed(target + R"({"format":"png","pixel":"uint8"})"));
    EXPECT_LE(kStudentT * *eight.report.error[0].standard_error_max, 1 / 1020.0);
    EXPECT_LT(eight.report.samples_total, half.report.samples_total / 2);
    job.target_error = 1e-2;
    EXPECT_FALSE(leaves_out(Baker()(job).report, "sampling below"));
    job.target_error.reset();  // without a target nothing stops early
    job.sample_count = 512;
    const Outcome plain = Baker()(job);
    EXPECT_EQ(plain.report.samples_total, 512u * 24 * 24);
    EXPECT_FALSE(leaves_out(plain.report, "sampling below"));
}

TEST(Adaptive, SharesOfOneChannelReachItsTargetTogether) {
    JobSpec job = parsed(R"("target_error":2e-3,"fresnel":{"model":"dielectric"},)"
                         R"("diffuse":{"model":"burley"},"coupling":"half_vector",)" +
                         kFloats);
    job.quantities = {Quantity::total_albedo, Quantity::average_albedo};
    const Outcome outcome = Baker()(job);
    EXPECT_EQ(outcome.report.status, "converged");
    for (const ChannelError& error : outcome.report.error)
        EXPECT_LE(kStudentT * *error.standard_error_max, 2e-3) << error.quantity;
}

TEST(Adaptive, SpeaksAndListensAtEveryLaunch) {
    EngineOptions options;
    options.device = DeviceChoice::native;
    Engine engine(options);
    const JobSpec job = parsed(R"("target_error":1e-9,)" + kFloats);
    double fraction = 0;
    int calls = 0;
    Control control;
    control.progress = [&](const Progress& progress) {
        EXPECT_GE(progress.fraction, fraction);
        EXPECT_LE(progress.fraction, 1);
        fraction = progress.fraction;
        ++calls;
    };
    control.cancelled = [&] { return calls == 20; };
    EXPECT_THROW(engine.run(job, control), Cancelled);
    EXPECT_EQ(calls, 20);
}

TEST(Adaptive, TheQuadratureTakesTargetAndTimeToo) {
    JobSpec job = parsed(R"("integrator":"quadrature",)" + kFloats);
    const std::uint64_t exact = Baker()(job).report.samples_total;
    job.target_error = 1e-3;
    const Outcome coarse = Baker()(job);
    EXPECT_EQ(coarse.report.status, "converged");
    EXPECT_LT(coarse.report.samples_total, exact);
    job.resolution = {256, 256};
    job.target_error.reset();
    job.time_budget_s = 0.001;
    const Outcome hasty = Baker()(job);
    EXPECT_EQ(hasty.report.status, "budget_exhausted");
    EXPECT_TRUE(says(hasty.report.warnings, "time_budget_s ended the quadrature"));
}

}  // namespace
}  // namespace kiln
