// SPDX-License-Identifier: Apache-2.0
#include <set>

#include "server/spec/contract.h"
#include "server/spec/words.h"
#include "server/study/furnace_pairs.h"
#include "tests/reference/coupling_models.h"
#include "tests/study/studying.h"

namespace kiln {
namespace {

using namespace studying;

struct Expected {
    const char* document;
    bool positive, conserving, reciprocal;
};

void expect(const Expected& expected) {
    SCOPED_TRACE(expected.document);
    const Study study = study_of(expected.document).study;
    EXPECT_EQ(verdict(study, "positivity").holds, expected.positive);
    EXPECT_EQ(verdict(study, "energy conservation").holds, expected.conserving);
    EXPECT_EQ(verdict(study, "reciprocity").holds, expected.reciprocal);
    // What does not hold is what is known of the model, not a surprise.
    for (const Verdict& one : study.verdicts)
        EXPECT_TRUE(one.holds || !one.expected) << one.name << ": " << one.words;
}

// "Physically-Based Materials: Energy Conservation and Reciprocity" (2020), its four materials.
TEST(Furnace, FindsWhatTheArticleSaysOfTheFourCouplings) {
    expect({R"({"kind":"furnace","coupling":"none"})", true, false, true});
    expect({R"({"kind":"furnace","coupling":"half_vector"})", true, false, true});
    expect({R"({"kind":"furnace","coupling":"view"})", true, true, false});
    expect({R"({"kind":"furnace","coupling":"kelemen"})", true, true, true});
}

TEST(Furnace, KelemenIsWhiteAllOver) {
    const Study study = study_of(R"({"kind":"furnace","coupling":"kelemen"})").study;
    EXPECT_TRUE(verdict(study, "nothing is lost").holds);
}

/// A diffuse model alone in the furnace.
Study alone(std::string_view model, const char* albedo) {
    return study_of(R"({"kind":"furnace","sample_count":4096,"coupling":"view",)"
                    R"("fresnel":{"model":"schlick","f0":0,"f90":0},"diffuse":{"model":")" +
                    std::string(model) + "\",\"albedo\":" + albedo + "}}")
        .study;
}

// What a model fails is known of it, and what is known of it is so: whoever adds one says it beside
// its word.
TEST(Furnace, OfEveryDiffuseModelIsKnownWhatItFails) {
    for (const std::string_view word : words<DiffuseModel>()) {
        const auto model = from_word<DiffuseModel>(word).value();
        if (model == DiffuseModel::none) continue;
        // Of a white one light that came back and forth may hide what is negative in the rest.
        const Study white = alone(word, "1"), dark = alone(word, "0.05");
        const KnownOfModel known = known_of(model);
        const auto hold = [&](const char* name, bool listed, const char* list) {
            const bool by_dark = verdict(white, name).holds;
            const Verdict& found = verdict(by_dark ? dark : white, name);
            EXPECT_EQ(found.holds, !listed)
                << word << ": " << found.words << "\nIf " << word << " was published so, add it to "
                << list << " of diffuse.model/x-kiln-known in "
                << "api/openapi.json; if it is listed there, take it out.";
            EXPECT_EQ(found.words.find(" as published)") != std::string::npos, listed)
                << found.words;
        };
        hold("positivity", known.negative, "negative");
        hold("energy conservation", known.exceeds_one, "exceeds_one");
        hold("reciprocity", known.not_reciprocal, "not_reciprocal");
    }
}

std::string words_of(const std::string& fields, const char* name) {
    const Study study = study_of(R"({"kind":"furnace","sample_count":4096,)" + fields + "}").study;
    return verdict(study, name).words;
}

// All that is at work in a material, and nothing that is not.
TEST(Furnace, EveryReasonIsNamed) {
    const auto reasons = [](const std::string& fields, const char* name) {
        const std::string words = words_of(fields, name);
        const std::size_t start = words.find(" (");
        return start == std::string::npos ? "" : words.substr(start + 1);
    };
    const std::string unreal = R"("diffuse":{"model":"eon_unreal"})";
    const std::string mirrors = R"("fresnel":{"model":"none"})";
    EXPECT_EQ(reasons(unreal + R"(,"multiscatter":"turquin")", "reciprocity"),
              "(Turquin's factor depends on V alone; eon_unreal is not reciprocal as published)");
    EXPECT_EQ(reasons(unreal + R"(,"coupling":"view")", "reciprocity"),
              "(F(NoV) stands without its like for L; eon_unreal is not reciprocal as published)");
    EXPECT_EQ(reasons(R"("diffuse":{"model":"eon_unreal","albedo":0},"multiscatter":"turquin")",
                      "reciprocity"),
              "(Turquin's factor depends on V alone)");
    const std::string charlie = R"("microfacet":{"distribution":"charlie"},)" + mirrors;
    const std::string uncoupled =
        "nothing takes from the diffuse lobe what the specular one reflects";
    EXPECT_EQ(reasons(charlie + R"(,"diffuse":{"model":"burley"})", "energy conservation"),
              "(Charlie's lobe exceeds 1 as published; burley exceeds 1 as published; " +
                  uncoupled + ")");
    EXPECT_EQ(reasons(R"("diffuse":{"model":"eon_unreal","albedo":0.9},"fresnel":{"model":"none"})",
                      "energy conservation"),
              "(" + uncoupled + ")");
    EXPECT_EQ(reasons(R"("diffuse":{"model":"chan2018"},"fresnel":{"model":"f82_tint","f0":0.04,)"
                      R"("f82":0})",
                      "positivity"),
              "(F82's formula is negative there; chan2018 is negative at some pairs as published)");
}

TEST(Furnace, SheenExceedsOneAndSaysSo) {
    expect({R"({"kind":"furnace","diffuse":{"model":"none"},)"
            R"("microfacet":{"distribution":"charlie","masking":"neubelt"},)"
            R"("fresnel":{"model":"none"}})",
            true, false, true});
    expect({R"({"kind":"furnace","diffuse":{"model":"chan2018"}})", false, false, true});
    expect({R"({"kind":"furnace","diffuse":{"model":"none"},"multiscatter":"kulla_conty",)"
            R"("microfacet":{"distribution":"charlie","masking":"neubelt"}})",
            false, true, true});
}

TEST(Furnace, WhatIsAloneInTheFurnaceExceedsOneByItself) {
    const Study study = study_of(R"({"kind":"furnace","diffuse":{"model":"burley"},)"
                                 R"("fresnel":{"model":"dielectric","ior":1}})")
                            .study;
    const std::string words = verdict(study, "energy conservation").words;
    EXPECT_NE(words.find("(burley exceeds 1 as published)"), std::string::npos) << words;
}

TEST(Furnace, CompensationByKullaContyLosesNothingAndStaysReciprocal) {
    const std::string metal = R"({"kind":"furnace","diffuse":{"model":"none"},)"
                              R"("fresnel":{"model":"none"})";
    const Study bare = study_of(metal + "}").study;
    EXPECT_FALSE(verdict(bare, "nothing is lost").holds);
    // E(1) = 1 - ln 2 at alpha = 1, the darkest place (facts of the closed form).
    EXPECT_NEAR(verdict(bare, "nothing is lost").value.value(), 0.3069, 0.005);
    const Study whole = study_of(metal + R"(,"multiscatter":"kulla_conty"})").study;
    EXPECT_TRUE(verdict(whole, "nothing is lost").holds);
    EXPECT_TRUE(verdict(whole, "energy conservation").holds);
    EXPECT_TRUE(verdict(whole, "reciprocity").holds);
    const Study turquin = study_of(metal + R"(,"multiscatter":"turquin"})").study;
    EXPECT_FALSE(verdict(turquin, "reciprocity").holds);
    EXPECT_FALSE(verdict(turquin, "reciprocity").expected);
}

// In double, of all that is made of albedos: a million pairs leave the last digits of double. (In
// float, of baked tables: test_kernels Reciprocity.*)
TEST(Furnace, WhatIsMadeOfAlbedosIsReciprocalToDouble) {
    for (const char* word : {"kulla_conty", "kulla_conty_linear"}) {
        const Study study = study_of(R"({"kind":"furnace","coupling":"kelemen","multiscatter":")" +
                                     std::string(word) + "\"}")
                                .study;
        EXPECT_LT(verdict(study, "reciprocity").value.value(), 1e-12) << word;
        std::set<double> rows;
        for (std::size_t row = 0; row < study.table.rows.size(); ++row)
            rows.insert(number(study.table, row, "roughness"));
        EXPECT_GE(rows.size() * kPairs, 1000000u);
    }
}

// F82's formula is negative above VoH = 1/7 for a low f82 (facts of the model).
TEST(Furnace, NegativeReflectanceIsFound) {
    const Study study = study_of(R"({"kind":"furnace","diffuse":{"model":"none"},)"
                                 R"("fresnel":{"model":"f82_tint","f0":0.04,"f82":0}})")
                            .study;
    EXPECT_FALSE(verdict(study, "positivity").holds);
    EXPECT_FALSE(verdict(study, "positivity").expected);
    EXPECT_LT(verdict(study, "positivity").value.value(), 0);
}

// The table beside a reference that shares no line: within five reported standard errors, of which
// rounding in float may take 5e-6.
TEST(Furnace, TableIsTheReferencesFurnace) {
    const Study study =
        study_of(R"({"kind":"furnace","coupling":"half_vector","sample_count":4096})").study;
    const reference::Material material(
        reference::Coupling::half_vector,
        {{reference::Distribution::ggx, reference::Visibility::smith_correlated, 1},
         reference::fresnel_schlick(0.04),
         reference::Multiscatter::none},
        {reference::DiffuseModel::lambert});
    std::size_t compared = 0;
    for (std::size_t row = 0; row < study.table.rows.size(); row += 7) {
        if (number(study.table, row, "roughness") != 1) continue;
        const double truth = material.total(number(study.table, row, "NoV"));
        const double error = number(study.table, row, "standard_error");
        EXPECT_NEAR(number(study.table, row, "total_albedo"), truth, 5 * error + 5e-6);
        ++compared;
    }
    EXPECT_GE(compared, 8u);
}

TEST(Furnace, ColouredMaterialsHaveThreeColumnsAndColouredBalls) {
    const Study study = study_of(R"({"kind":"furnace","diffuse":{"model":"none"},)"
                                 R"("fresnel":{"model":"conductor","metal":"gold"}})")
                            .study;
    EXPECT_EQ(study.table.columns.size(), 8u);
    const auto& ball = std::get<FurnaceBalls>(study.charts[0]).balls.front();
    EXPECT_GT(ball.by_NoV.back()[0], ball.by_NoV.back()[2] + 0.3);  // gold is yellow
}

TEST(Furnace, CanBeCancelled) {
    Engine engine = native_engine();
    Control control;
    control.cancelled = [] { return true; };
    EXPECT_THROW(make_study(engine, parse_job(R"({"kind":"furnace"})"), control), Cancelled);
}

}  // namespace
}  // namespace kiln
