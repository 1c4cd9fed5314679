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

// The same error, found anew: Kiln's tables of the three seeds beside the reference.
TEST(Convergence, ErrorsAreDistancesFromTheTruth) {
    JobSpec job = parse_job(kDocument);
    job.kind = Kind::lut;
    job.integrator = Integrator::monte_carlo;
    job.sample_count = 256;
    Engine engine = native_engine();
    double sum = 0;
    for (job.seed = 0; job.seed < 3; ++job.seed) {
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

// Tables of F at 5 and 1 %: Abramowitz, Stegun 1964, table 26.9.
TEST(Convergence, QuantilesOfFAreThoseOfTheTables) {
    EXPECT_NEAR(f_quantile(3, 40, 0.05), 2.84, 0.005);
    EXPECT_NEAR(f_quantile(3, 60, 0.01), 4.13, 0.005);
    EXPECT_NEAR(f_quantile(1, 30, 0.05), 4.17, 0.005);
    EXPECT_NEAR(honest_ratio(3, 16, 1) * honest_ratio(3, 16, 1), f_quantile(3, 45, 0.05), 1e-6);
}

// What is reported holds, and half of it would not: the limit is no wider than the figures need.
TEST(Convergence, ReportedErrorsAreHonestAndLowerOnesAreSeen) {
    const Verdict& honest = verdict(study(), "reported errors are honest");
    EXPECT_TRUE(honest.holds) << honest.words;
    EXPECT_NEAR(honest.bound.value(), honest_ratio(3, 16, 16 * 8), 1e-9);
    EXPECT_LT(honest.bound.value(), 3);
    EXPECT_GT(2 * honest.value.value(), honest.bound.value());
}

}  // namespace
}  // namespace kiln
