// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <map>

#include "server/study/honest.h"
#include "tests/reference/reference.h"
#include "tests/study/studying.h"

namespace kiln {
namespace {

using namespace studying;

constexpr const char* kDocument =
    R"({"kind":"convergence","quantities":["directional_albedo"],"resolution":[8,8],)"
    R"("layout":{"x":{"parameter":"NoV"},"y":{"parameter":"roughness","range":[0.3,1]}},)"
    R"("sample_count":4096,"device":"native"})";

const Study& study() {
    static const Study made = study_of(kDocument).study;
    return made;
}

/// rms error of each sample count of one recipe.
std::map<double, double> curve(const std::string& sampler, const std::string& importance) {
    std::map<double, double> found;
    const StudyTable& table = study().table;
    for (std::size_t row = 0; row < table.rows.size(); ++row)
        if (table.rows[row][1].word == sampler && table.rows[row][2].word == importance)
            found[number(table, row, "sample_count")] = number(table, row, "error_rms");
    return found;
}

TEST(Convergence, GoesThroughEverySamplerAndImportance) {
    for (const char* sampler : {"hammersley", "sobol_owen", "lattice", "random"})
        for (const char* importance : {"vndf", "ndf", "cosine", "uniform"})
            EXPECT_EQ(curve(sampler, importance).size(), 8u) << sampler << ' ' << importance;
}

std::size_t row_of(const std::string& sampler, const std::string& importance, double samples) {
    const StudyTable& table = study().table;
    std::size_t row = 0;
    while (table.rows.at(row)[1].word != sampler || table.rows[row][2].word != importance ||
           number(table, row, "sample_count") != samples)
        ++row;
    return row;
}

// The same error, found anew: Kiln's tables of the three seeds beside the reference.
TEST(Convergence, ErrorsAreDistancesFromTheTruth) {
    JobSpec job = parse_job(kDocument);
    job.kind = Kind::lut;
    job.integrator = Integrator::monte_carlo;
    job.sample_count = 256;
    Engine engine = native_engine();
    double sum = 0;
    const std::uint64_t first = 3 * row_of("sobol_owen", "vndf", 256);  // three seeds a row
    for (job.seed = first; job.seed < first + 3; ++job.seed) {
        const Table table = engine.run(job, Control{}).table;
        for (int y = 0; y < 8; ++y)
            for (int x = 0; x < 8; ++x) {
                const double roughness = 0.3 + 0.7 * (y + 0.5) / 8;
                const double truth = reference::directional_albedo(
                    (x + 0.5) / 8, roughness * roughness, reference::Masking::correlated);
                const double off =
                    static_cast<double>(table.planes[0][static_cast<std::size_t>(y * 8 + x)]) -
                    truth;
                sum += off * off;
            }
    }
    // The study's truth is a table of floats: 6e-8 beside an error of 1e-3.
    EXPECT_NEAR(curve("sobol_owen", "vndf")[256], std::sqrt(sum / (3 * 64)), 1e-6);
}

double order(const std::map<double, double>& points) {
    const auto &first = *points.begin(), &last = *points.rbegin();
    return std::log(last.second / first.second) / std::log(last.first / first.first);
}

// Independent points: -1/2. The texels of a run share their points, so an rms over three runs
// strays by some 40 % from its mean: over seven doublings 0.12 of the order; nearly three times
// that. Scrambled Sobol points of a smooth integrand beat -0.85 (facts of the samplers).
TEST(Convergence, OrdersAreThoseOfTheSamplers) {
    EXPECT_NEAR(order(curve("random", "vndf")), -0.5, 0.3);
    EXPECT_LE(order(curve("sobol_owen", "vndf")), -0.85);
}

TEST(Convergence, QuadratureIsFarBelowEveryCurve) {
    const StudyTable& table = study().table;
    ASSERT_EQ(table.rows.back()[1].word, "quadrature");
    EXPECT_LE(number(table, table.rows.size() - 1, "error_max"), 1e-6);
}

// The binomial distribution has the widest tail of all means of numbers in [0, 1]: Hoeffding's
// limit is beyond its quantile, and by no more than half of what lies between that and the mean.
TEST(Convergence, TheLimitOfMissesIsJustBeyondTheBinomialTail) {
    for (const int runs : {24, 84, 384})
        for (const double level : {1e-4, 1e-5}) {
            const auto beyond = [&](double share) {
                double tail = 0;
                for (int k = static_cast<int>(std::ceil(share * runs)); k <= runs; ++k)
                    tail += std::exp(std::lgamma(runs + 1) - std::lgamma(k + 1) -
                                     std::lgamma(runs - k + 1) + k * std::log(.08) +
                                     (runs - k) * std::log(.92));
                return tail;
            };
            const double limit = most_missed(static_cast<std::size_t>(runs), level);
            EXPECT_LT(beyond(limit), level) << runs;
            EXPECT_GT(beyond(.08 + (limit - .08) / 1.5), level) << runs;
        }
}

/// What the study would say of standard errors `times` as large as reported.
Verdict honest_at(const JobSpec& base, double times) {
    Engine engine = native_engine();
    JobSpec exact = base;
    exact.integrator = Integrator::quadrature;
    const Table truth = engine.run(exact, Control{}).table;
    JobSpec job = base;
    std::vector<JudgedRun> runs;
    for (const Importance importance : {Importance::vndf, Importance::ndf, Importance::cosine})
        for (const Sampler sampler : {Sampler::sobol_owen, Sampler::lattice, Sampler::random})
            for (std::int64_t n = 32; n <= 1024; n *= 2)
                for (int run = 0; run < 3; ++run, ++job.seed) {
                    job.importance = importance;
                    job.sampler = sampler;
                    job.sample_count = n;
                    runs.push_back(judged_run(job, engine.run(job, Control{}, true), truth, times));
                }
    return honest_errors(runs);
}

constexpr const char* kJudged[] = {
    R"({"quantities":["directional_albedo"],"resolution":[8,8],"device":"native"})",
    R"({"quantities":["directional_albedo"],"resolution":[1,1],"device":"native",)"
    R"("layout":{"x":{"parameter":"NoV"},"y":{"parameter":"roughness","range":[0.3,1]}}})",
    R"({"quantities":["average_albedo"],"resolution":[16],"device":"native"})",
    R"({"quantities":["diffuse_albedo"],"resolution":[8,8],"device":"native",)"
    R"("diffuse":{"model":"burley"}})"};

// Halves of what is reported are found by every seed, and what is reported is never blamed.
TEST(Convergence, ReportedErrorsAreHonestAndHalvesOfThemAreNot) {
    for (const char* document : kJudged)
        for (const std::uint64_t seed : {0u, 100000u, 200000u}) {
            JobSpec job = parse_job(document);
            job.seed = seed;
            const Verdict honest = honest_at(job, 1), halved = honest_at(job, 0.5);
            EXPECT_TRUE(honest.holds) << document << seed << honest.words;
            EXPECT_FALSE(halved.holds) << document << seed << halved.words;
            EXPECT_TRUE(halved.expected) << "a study would not fail";
        }
}

TEST(Convergence, SaysThatReportedErrorsAreHonest) {
    const Verdict& honest = verdict(study(), "reported errors are honest");
    EXPECT_TRUE(honest.holds) << honest.words;
    EXPECT_LT(honest.value.value(), honest.bound.value());
    // At its lowest roughness cosine and uniform samples miss the peak, and their runs say so.
    EXPECT_NE(honest.words.find("192 of 384 runs"), std::string::npos) << honest.words;
}

// Cosines miss the lobe of a mirror, and reports say so: nothing is blamed on them.
TEST(Convergence, RunsThatSayThatTheyMissedAreNotJudged) {
    const std::vector<JudgedRun> missed(100, {Importance::cosine, 1, true});
    EXPECT_TRUE(honest_errors(missed).holds);
    const std::vector<JudgedRun> silent(100, {Importance::cosine, 1, false});
    EXPECT_FALSE(honest_errors(silent).holds);
}

}  // namespace
}  // namespace kiln
