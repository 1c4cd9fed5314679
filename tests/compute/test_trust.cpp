// SPDX-License-Identifier: Apache-2.0
// Each detector of estimates that cannot be trusted is seen to fire, and not to.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "server/compute/rare_events.h"
#include "server/compute/replicates.h"
#include "server/compute/stopping.h"
#include "server/compute/trust.h"
#include "server/spec/spec.h"
#include "tests/compute/sampled_places.h"

namespace kiln {
namespace {

using namespace sampled_places;

Report report_of(const std::string& fields) {
    JobSpec job = parse_job("{" + fields + "}");
    job.device = DeviceChoice::native;
    return Baker()(job).report;
}

bool names_places(const Report& report) {
    return std::any_of(report.warnings.begin(), report.warnings.end(), [](const std::string& text) {
        return text.find("rare events: at ") == 0 && text.find("alpha ") != std::string::npos;
    });
}

const std::string kSplitSum = R"("quantities":["split_sum_scale","split_sum_bias"])";

// The leading order that the detectors rely on, against quadrature: within a factor of two wherever
// it is below 0.01.
TEST(Trust, ExpectedDeficitIsRightWithinAFactorOfTwo) {
    for (const Masking masking : {Masking::smith_correlated, Masking::smith_separable})
        for (int i = 0; i <= 24; ++i)
            for (int j = 0; j <= 24; ++j) {
                const double NoV = std::pow(10, -i / 6.0), alpha = std::pow(10, -j / 6.0);
                KernelMaterial what;
                what.masking = static_cast<int>(masking);
                const double expected = expected_deficit(what, NoV, alpha);
                if (!(expected < .01)) continue;
                const double exact = quadrature_deficit(NoV, alpha, masking);
                EXPECT_LE(std::abs(std::log2(expected / exact)), 1.2) << NoV << ' ' << alpha;
            }
}

// Directions drawn from a cosine hardly ever meet the lobe at α < .02, and agree that there is
// none; drawn from visible normals the same table is done.
TEST(Trust, ASamplerThatMissesTheLobeIsSuspected) {
    const std::string job = kSplitSum + R"(,"resolution":[16,16],"importance":)";
    const Report cosine = report_of(job + R"("cosine")");
    EXPECT_EQ(cosine.status, "rare_event_suspected");
    EXPECT_TRUE(names_places(cosine));
    const Report visible = report_of(job + R"("vndf")");
    EXPECT_EQ(visible.status, "done");
    EXPECT_TRUE(visible.warnings.empty());
}

// The same of any lobe and Fresnel term, wherever the peak is met less than 30 times in the mean:
// 4096 cosine samples meet that of alpha .15 at NoV .3 33 times, those of alpha .1 15 times.
TEST(Trust, WhereSamplesOfTheHemisphereMissThePeakIsSuspected) {
    const auto status = [](const std::string& alpha, const std::string& rest) {
        return report_of(R"("quantities":["specular_albedo"],"fresnel":{"model":"conductor",)"
                         R"("eta":0.2,"k":3.4},"sample_count":4096,"resolution":[4,1],"layout":{)"
                         R"("x":{"parameter":"NoV","grid":"node","range":[0.3,1]},"y":{)"
                         R"("parameter":"alpha","grid":"node","range":[)" +
                         alpha + R"(,1]}},"microfacet":{"distribution":)" + rest)
            .status;
    };
    for (const std::string lobe : {R"("beckmann")", R"("ggx")"}) {
        EXPECT_EQ(status("0.1", lobe + R"(},"importance":"cosine")"), "rare_event_suspected");
        EXPECT_EQ(status("0.15", lobe + R"(},"importance":"cosine")"), "done");
        EXPECT_EQ(status("0.1", lobe + "}"), "done");
    }
    EXPECT_EQ(status("0.1", R"("charlie","masking":"neubelt"},"importance":"cosine")"), "done");
}

// What a plain job says: every row of the first-result table, roughness .002 included.
TEST(Trust, ADefaultJobIsDone) {
    const Report table = report_of(kSplitSum);
    EXPECT_EQ(table.status, "done");
    EXPECT_TRUE(table.warnings.empty());
    const Report all =
        report_of(R"("quantities":["directional_albedo","multiscatter_albedo","average_albedo",)"
                  R"("specular_albedo"],"fresnel":{"model":"dielectric"},"resolution":[32,32])");
    EXPECT_EQ(all.status, "done");
    EXPECT_TRUE(all.warnings.empty());
}

// α of .0079 at NoV .1: 1 − E is twice its leading order's half and no less; a value of twice or a
// quarter of it is refused, one inside its own bound is not.
TEST(Trust, AnalyticCheckOfTheDeficit) {
    JobSpec job = grid_job({.3, .5, 2}, {.001, .01, 2}, 1024);
    job.quantities = {Quantity::multiscatter_albedo};
    const Plan plan = make_plan(job, [] { return Averages{}; });
    const Pass& pass = plan.passes.at(0);
    const Share& share = pass.shares.at(0);
    for (std::size_t place = 0; place < 4; ++place) {
        const double NoV = pass.places.NoV(place), alpha = pass.places.alpha(place);
        const double deficit = quadrature_deficit(NoV, alpha, job.masking);
        const auto refuses = [&](double value, double bound) {
            return misses_mirror_limit(pass, share, place, {value, 0, 0}, bound);
        };
        EXPECT_FALSE(refuses(deficit, 0));
        EXPECT_TRUE(refuses(.25 * deficit, 0));
        EXPECT_TRUE(refuses(4 * deficit, 0));
        EXPECT_FALSE(refuses(.25 * deficit, deficit));
        EXPECT_FALSE(refuses(4 * deficit, 4 * deficit));
    }
}

// 1 − E of .009 by visible normals: 9 events in 1024 samples are too few to claim anything finer,
// however well the replicates agree; 600 are enough.
TEST(Trust, FewerThanThirtyRareEventsAreNoConvergence) {
    KernelMaterial what;
    const double deficit = expected_deficit(what, .3, .04);
    ASSERT_GT(deficit, .005);
    ThreadPool pool(1);
    for (const std::int64_t samples : {1024, 65536}) {
        Mean mean;
        mean.terms[kWeight] = 1;
        const PointSet set =
            make_points(Sampler::sobol_owen, PointKind::visible_normals, 1, samples);
        Replicates replicates({mean});
        replicates.reset({1, {{}}, {{deficit}}, {{1}}});
        const std::vector<float> ones(kLanesMax, 64.0f);  // all agree
        TermSums<float> sums;
        sums.data[kWeight] = ones.data();
        replicates.add(pool, set, 0, set.batches.size(), sums);
        Estimate estimate;
        replicates.estimates(0, 0, std::span(&estimate, 1));
        EXPECT_EQ(lacks_rare_events(estimate, deficit / 2), samples == 1024);
        EXPECT_FALSE(lacks_rare_events(estimate, 2 * deficit));
    }
    const std::string job = R"("quantities":["directional_albedo"],"resolution":[16,16],)"
                            R"("target_error":0.001,"output":{"pixel":"float"},"sample_count":)";
    const Report few = report_of(job + "1024");
    EXPECT_EQ(few.status, "rare_event_suspected");
    EXPECT_TRUE(names_places(few));
    EXPECT_EQ(report_of(job + "65536").status, "converged");
}

TEST(Trust, RareEventsWidenTheErrorUntilEightAreExpected) {
    EXPECT_DOUBLE_EQ(with_rare_events(2e-7, 1e-7, .1), 2e-7);
    EXPECT_DOUBLE_EQ(with_rare_events(0, 1e-7, .1), 1e-7);
    EXPECT_DOUBLE_EQ(with_rare_events(2e-7, 3e-7, 5), 3e-7);
    EXPECT_DOUBLE_EQ(with_rare_events(4e-7, 3e-7, 5), 4e-7);
    EXPECT_DOUBLE_EQ(with_rare_events(2e-7, 3e-7, 8), 2e-7);
    // What all replicates missed lies within two such deviations: 2 sqrt(d / n) > d for d n < 3.
    for (const double events : {1e-6, .1, 1.0, 2.9, 3.0, 4.5})
        EXPECT_GT(kStudentT * std::sqrt(with_rare_events(0, events / 1e6, events)), events / 1000);
}

// Half vectors drawn from D meet grazing light in rare samples of great weight: some seeds in
// twenty see the error fall by less than 2^-1.2 over three doublings; by visible normals none does.
TEST(Trust, AFlatTraceIsSuspected) {
    const auto flat_seeds = [](const std::string& importance) {
        int flat = 0;
        for (int seed = 0; seed < 20; ++seed) {
            const Report report = report_of(
                R"("quantities":["directional_albedo"],"resolution":[4,4],"target_error":1e-6,)"
                R"("layout":{"x":{"parameter":"NoV","range":[0.0005,0.002]},)"
                R"("y":{"parameter":"alpha","range":[0.009,0.011]}},"sample_count":8192,)"
                R"("output":{"pixel":"float"},"importance":")" +
                importance + R"(","seed":)" + std::to_string(seed));
            const bool said = std::any_of(
                report.warnings.begin(), report.warnings.end(),
                [](const auto& text) { return text.find("hardly fell") != std::string::npos; });
            EXPECT_TRUE(!said || report.status == "rare_event_suspected");
            flat += said;
        }
        return flat;
    };
    EXPECT_GT(flat_seeds("ndf"), 0);
    EXPECT_EQ(flat_seeds("vndf"), 0);
    JobSpec sobol, random;
    random.sampler = Sampler::random;
    const StoppingRules net(sobol), plain(random);
    EXPECT_TRUE(net.is_flat(1e-3, 6e-4));     // -.25
    EXPECT_FALSE(net.is_flat(1e-3, 3e-4));    // -.58
    EXPECT_FALSE(plain.is_flat(1e-3, 6e-4));  // noise about -.5
    EXPECT_TRUE(plain.is_flat(1e-3, 9e-4));
    EXPECT_FALSE(net.is_flat(0, 0));
}

TEST(Trust, OnePassingLevelIsNotEnough) {
    JobSpec job;
    job.target_error = 1e-3;
    job.quantities = {Quantity::directional_albedo};
    const StoppingRules rules(job);
    LevelVerdict good, bad;
    bad.passes = false;
    const auto stops = [&](std::vector<LevelVerdict> verdicts, double alpha) {
        Progressed place;
        std::uint64_t samples = 512;
        for (const LevelVerdict& verdict : verdicts) place.add(verdict, rules, alpha, samples *= 2);
        return place.stopped;
    };
    EXPECT_FALSE(stops({good}, 1));
    EXPECT_TRUE(stops({good, good}, 1));
    EXPECT_FALSE(stops({good, bad, good}, 1));
    EXPECT_TRUE(stops({bad, good, good}, 1));
    EXPECT_FALSE(stops({good, good}, .05)) << "2048 samples are 128 points a replicate";
    EXPECT_TRUE(stops({good, good, good}, .05));
}

}  // namespace
}  // namespace kiln
