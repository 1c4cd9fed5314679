// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <limits>
#include <map>
#include <string>

#include "server/base/error.h"
#include "server/spec/words.h"
#include "server/study/stability.h"
#include "server/study/studies.h"

// The stability study on every backend of this machine, and values that it does not know of.
namespace kiln {
namespace {

JobSpec stability_job() {
    JobSpec job;
    job.kind = Kind::stability;
    return job;
}

/// One run for all tests of a process.
const Studied& studied() {
    static const Studied made = [] {
        EngineOptions options;
        options.opencl_wait = std::chrono::minutes(5);
        Engine engine(options);
        return make_study(engine, stability_job(), Control{});
    }();
    return made;
}

std::size_t column(const std::string& name) {
    const auto& columns = studied().study.table.columns;
    for (std::size_t c = 0; c < columns.size(); ++c)
        if (columns[c] == name) return c;
    ADD_FAILURE() << "no column " << name;
    return 0;
}

/// The row of a case, a quantity and a place; alpha < 0 where the row has none.
const std::vector<Cell>* row_of(const std::string& which, const std::string& quantity, double NoV,
                                double alpha) {
    const std::size_t at_case = column("case"), at_quantity = column("quantity"),
                      at_NoV = column("NoV"), at_alpha = column("alpha");
    for (const auto& row : studied().study.table.rows) {
        if (row[at_case].word != which || row[at_quantity].word != quantity) continue;
        if (row[at_NoV].number.value_or(-1) == NoV && row[at_alpha].number.value_or(-1) == alpha)
            return &row;
    }
    return nullptr;
}

struct Spot {
    const char *which, *quantity;
    double NoV, alpha, value;
    double single, twice;  ///< how far float and double may be off
};

// None of these numbers was made by this program. F: exact formulas in double to all printed
// digits, which leaves half of the last of them. g(1): E at NoV = alpha as alpha -> 0. Closed forms
// of E at alpha = 1. 1 - E: alpha^2 (1 + 1 / NoV^2) / 2,
// of which the next term is 4 alpha / 3 NoV. Float: 1e-6, that is sixteen units of the
// last place, or what the quadrature promises.
const Spot kSpots[] = {
    {"conductor, 1e-4 + 5i", "F", 1, 0, .99998462, 1e-6, 5e-9},
    {"conductor, 1e-4 + 5i", "F", 0.5, 0, .99998186, 1e-6, 5e-9},
    {"conductor, 1 + 1e-6i", "F", 1e-3, 0, .119726, 1e-6, 5e-7},
    {"conductor, 1e5 + 1e5i", "F", 1, 0, .99998000, 1e-6, 5e-9},
    {"conductor, 1e5 + 1e5i", "F", 1e-3, 0, .99009949, 1e-6, 5e-9},
    {"dielectric, 1 + 1e-7", "F", 1e-3, 0, 2.0747e-3, 1e-7, 5e-8},
    {"dielectric, 1 + 1e-7", "F", 1, 0, 2.5e-15, 1e-20, 1e-20},
    {"dielectric, 1/1.5", "F", 0.5, 0, 1, 0, 0},
    {"dielectric, 1e3", "F", 1, 0, .996008, 1e-6, 5e-7},
    {"dielectric, 1e3", "F", 1e-3, 0, .499998, 1e-6, 5e-7},
    {"dielectric, 1e6", "F", 1, 0, .999996, 1e-6, 5e-7},
    {"dielectric, 1", "F", 0, 0, 0, 0, 0},
    {"schlick, F0 1", "F", 0.1, 0, 1, 0, 0},
    {"ggx, smith_correlated: E", "E", 1e-6, 1e-6, .892075, 2e-6, 5e-7},
    {"ggx, smith_separable: E", "E", 1e-6, 1e-6, .881618, 2e-6, 5e-7},
    {"ggx, smith_correlated: E", "E", 0, 1, 1, 0, 0},
    {"ggx, smith_separable: E", "E", 0, 1, .613705638880109, 1e-6, 1e-12},
    {"ggx, smith_correlated: E", "E", 1, 1, .3068528194400547, 1e-6, 1e-12},
    {"ggx, smith_correlated: 1 - E", "1 - E", 0.5, 1e-4, 2.5e-8, 1e-11, 1e-11},
    {"ggx, smith_correlated: B", "B", 0.5, 0, .03125, 1e-7, 1e-15},
    // Over 64 000 x 8 half vectors with the azimuth split where total reflection begins.
    {"dielectric, 1/1.5", "albedo", 0x1p-10, 1, .592166779507, 1e-6, 2e-9},
    {"albedo 1", "albedo 1", 1e-6, 1e-3, 1, 1e-12, 1e-12},
    {"eon: albedo 1", "albedo 1", 0x1p-10, 1, 1, 1e-6, 1e-12},
};

void every_expected_verdict_holds() {
    for (const Verdict& verdict : studied().study.verdicts)
        EXPECT_TRUE(verdict.holds || !verdict.expected) << verdict.name << ": " << verdict.words;
}

/// What is known to go wrong is said, and is not asserted away.
void it_says_which_models_rightly_misbehave() {
    std::map<std::string, const Verdict*> verdicts;
    for (const Verdict& verdict : studied().study.verdicts) verdicts[verdict.name] = &verdict;
    for (const char* name :
         {"every model is finite", "F is nowhere negative", "no lobe reflects more than it gets"}) {
        ASSERT_TRUE(verdicts.contains(name)) << name;
        EXPECT_FALSE(verdicts[name]->expected) << name;
        EXPECT_FALSE(verdicts[name]->holds) << name;
    }
    ASSERT_TRUE(verdicts.contains("an index of 1e10 is refused"));
    EXPECT_TRUE(verdicts["an index of 1e10 is refused"]->holds);
}

void every_model_of_the_contract_has_a_verdict() {
    std::map<std::string, int> names;
    for (const Verdict& verdict : studied().study.verdicts) ++names[verdict.name];
    for (const char* name : {"F none",
                             "F schlick",
                             "F dielectric",
                             "F conductor",
                             "F edge_tint",
                             "F f82_tint",
                             "ggx, smith_correlated",
                             "ggx, smith_separable",
                             "ggx, karis_ibl",
                             "ggx, karis_direct",
                             "ggx, unreal_joint",
                             "beckmann, smith_correlated",
                             "beckmann, smith_separable",
                             "charlie, neubelt",
                             "charlie, charlie",
                             "charlie, charlie, softened",
                             "kulla_conty",
                             "kulla_conty_linear",
                             "turquin",
                             "coupling none",
                             "coupling half_vector",
                             "coupling view",
                             "coupling kelemen",
                             "quadrature, ggx, karis_ibl",
                             "quadrature, beckmann, smith_correlated",
                             "quadrature, charlie, charlie, softened",
                             "quadrature, dielectric, 1/1.5",
                             "quadrature, conductor, 1e-4 + 5i",
                             "spikes in measured files",
                             "a measured value of 1e39 is refused, by its point",
                             "a measured value of nan is refused, by its line",
                             "a measured value of -inf is refused, by its line",
                             "1 - E_avg",
                             "F_avg"})
        EXPECT_EQ(names[name], 1) << name;
    for (const std::string_view model : words<DiffuseModel>())
        if (model != "none") {
            EXPECT_EQ(names[model == "ggx_lambert" ? "ggx_lambert, solved" : std::string(model)], 1)
                << model;
        }
}

void values_from_elsewhere_agree() {
    for (const Spot& spot : kSpots) {
        const auto* row = row_of(spot.which, spot.quantity, spot.NoV, spot.alpha);
        ASSERT_NE(row, nullptr) << spot.which << ' ' << spot.quantity << ' ' << spot.NoV;
        const auto hold = [&](const char* arithmetic, double most) {
            const auto value = (*row)[column(arithmetic)].number;
            if (!value) return false;
            EXPECT_NEAR(*value, spot.value, most)
                << spot.which << ", " << spot.quantity << ", NoV " << spot.NoV << ", alpha "
                << spot.alpha << ", " << arithmetic;
            return true;
        };
        const bool single = hold("native_float", spot.single);
        const bool opencl = hold("opencl_float", spot.single);
        EXPECT_EQ(opencl, single && studied().report.device.backend == "opencl");
        EXPECT_TRUE(hold("native_double", spot.twice));
    }
}

/// Nothing that is no number passes, and no tolerance would let it.
void numbers_alone_are_within_tolerance() {
    for (const auto& row : studied().study.table.rows) {
        const std::string where = row[column("model")].word + ", " + row[column("input")].word;
        for (const char* name : {"native_float", "opencl_float", "native_double", "opencl_double"})
            EXPECT_FALSE(std::isnan(row[column(name)].number.value_or(0))) << where;
        for (const char* name : {"tolerance_float", "tolerance_double"})
            EXPECT_TRUE(std::isfinite(*row[column(name)].number)) << where;
    }
}

/// VoH there is 1, however steep F is below: Schlick's with an exponent of 1e-3, and at an ior of
/// 1e-4 total reflection begins at 1 - 5e-9. 32 units of the last place are for the steps of F, and
/// few more for the numbers that it reads.
void normal_incidence_is_held_tightly() {
    constexpr double kUnits = 40;
    for (const stability::FresnelRow& known : stability::fresnel_rows()) {
        const auto* row = row_of(known.name, "F", 1, 0);
        ASSERT_NE(row, nullptr) << known.name;
        EXPECT_LT(*(*row)[column("tolerance_float")].number, kUnits * 0x1p-24) << known.name;
        EXPECT_LT(*(*row)[column("tolerance_double")].number, kUnits * 0x1p-53) << known.name;
    }
}

/// A mean that samples cannot tell from 0, or that may be anything, is no test: of what is right
/// the tolerance is a part, or it is rounding.
void means_over_samples_can_fail() {
    std::size_t rows = 0;
    for (const auto& row : studied().study.table.rows) {
        const std::string& family = row[column("family")].word;
        if (family != "Sampled albedos" && family != "Diffuse albedos") continue;
        ++rows;
        const std::string where = row[column("model")].word + ", " + row[column("quantity")].word +
                                  " " + row[column("source")].word;
        const double right = std::abs(*row[column("right")].number);
        EXPECT_LT(*row[column("tolerance_float")].number, std::max(0.2 * right, 4e-6)) << where;
        EXPECT_LT(*row[column("tolerance_double")].number, std::max(0.2 * right, 1e-14)) << where;
    }
    EXPECT_GT(rows, 1100u);  // 82 of 1197 are not kept
}

// One test, since each is a process of its own and the study is what takes its time.
TEST(Stability, HoldsOnEveryBackend) {
    every_expected_verdict_holds();
    it_says_which_models_rightly_misbehave();
    every_model_of_the_contract_has_a_verdict();
    values_from_elsewhere_agree();
    numbers_alone_are_within_tolerance();
    normal_incidence_is_held_tightly();
    means_over_samples_can_fail();
}

constexpr double kInfinite = std::numeric_limits<double>::infinity();

/// A value beside what is right, in all arithmetics and in one.
bool passes(double value, stability::Right right) {
    stability::Finding finding{};
    finding.in_float = finding.in_double = right;
    finding.values.fill(value);
    const bool passes = finding.passes();
    EXPECT_EQ(passes, finding.strain() <= 1);
    for (std::size_t a = 0; a < stability::kArithmetics; ++a) {
        finding.values.fill(right.value);
        finding.values[a] = value;
        EXPECT_EQ(finding.passes(), passes) << a;
    }
    return passes;
}

/// A NaN fails beside everything; an infinity passes beside the same one alone, which is what is
/// right or a pole that the inputs cannot be told from.
TEST(Stability, NoToleranceIsWideEnoughForWhatIsNoNumber) {
    const double nan = std::nan("");
    for (const double tolerance : {0.0, 1e-25, 1e300, kInfinite, nan}) {
        for (const double right : {0.0, 5e-38, kInfinite, -kInfinite})
            EXPECT_FALSE(passes(nan, {right, tolerance, kInfinite})) << right << ' ' << tolerance;
        EXPECT_FALSE(passes(kInfinite, {5e-38, tolerance})) << tolerance;
        EXPECT_FALSE(passes(kInfinite, {-kInfinite, tolerance})) << tolerance;
        EXPECT_FALSE(passes(1, {kInfinite, tolerance})) << tolerance;
        EXPECT_FALSE(passes(-kInfinite, {5e-38, tolerance, kInfinite})) << tolerance;
        EXPECT_TRUE(passes(kInfinite, {kInfinite, tolerance})) << tolerance;
        EXPECT_TRUE(passes(kInfinite, {5e-38, tolerance, kInfinite})) << tolerance;
    }
    EXPECT_FALSE(passes(2, {1, 0.5, kInfinite}));
    EXPECT_FALSE(passes(2, {1, kInfinite}));
    EXPECT_TRUE(passes(1.25, {1, 0.5}));
}

/// A caller who wants out is heard, and one who listens is told.
TEST(Stability, StopsWhenAsked) {
    EngineOptions options;
    options.device = DeviceChoice::native;
    Engine engine(options);
    int told = 0;
    Control control;
    control.progress = [&](const Progress&) { ++told; };
    control.cancelled = [&] { return told == 20; };
    EXPECT_THROW(make_study(engine, stability_job(), control), Cancelled);
    EXPECT_EQ(told, 20);
}

}  // namespace
}  // namespace kiln
