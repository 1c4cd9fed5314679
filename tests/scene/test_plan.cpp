// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <map>

#include "server/compute/axes.h"
#include "server/compute/engine.h"
#include "server/scene/atlas_jobs.h"
#include "server/scene/plan_options.h"
#include "server/scene/scene_plan.h"
#include "server/spec/contract.h"
#include "server/spec/deficit.h"
#include "server/spec/spec.h"
#include "tests/scene/scenes.h"

namespace kiln {
namespace {

ScenePlan plan_of(const std::string& materials, const PlanOptions& options = {}) {
    return plan_scene(read_scene(R"({"materials":[)" + materials + "]}", {}), options);
}

bool left_out_by(const ScenePlan& plan, const std::string& rule) {
    return std::any_of(plan.left_out.begin(), plan.left_out.end(),
                       [&](const LeftOutOfPlan& entry) { return entry.rule == rule; });
}

std::string names_of(const ScenePlan& plan) {
    std::string names;
    for (const PlannedTable& table : plan.tables) names += (names.empty() ? "" : " ") + table.name;
    return names;
}

const char* const kPaint = R"({"lobes":["dielectric","diffuse"],"roughness":[0.2,0.6]})";
const char* const kMetal = R"({"lobes":["metal"],"roughness":0.4})";

TEST(Plan, NoSheenMeansNoTableOfCharlie) {
    EXPECT_TRUE(left_out_by(plan_of(kMetal), "no_sheen"));
    const ScenePlan plan = plan_of(R"({"lobes":["sheen"],"sheen_roughness":[0.3,0.6]})");
    EXPECT_FALSE(left_out_by(plan, "no_sheen"));
    EXPECT_EQ(names_of(plan), "sheen");
    EXPECT_EQ(plan.tables[0].job.distribution, Distribution::charlie);
    EXPECT_TRUE(left_out_by(plan, "no_specular"));
}

TEST(Plan, MetalsOnlyMeansNoDiffuseTables) {
    PlanOptions options;
    options.diffuse = DiffuseModel::burley;
    EXPECT_EQ(names_of(plan_of(kMetal, options)), "specular average");
    EXPECT_TRUE(left_out_by(plan_of(kMetal, options), "no_diffuse"));
    const ScenePlan plan = plan_of(kPaint, options);
    EXPECT_EQ(names_of(plan), "specular diffuse");
    EXPECT_EQ(plan.tables[1].job.diffuse.model, DiffuseModel::burley);
    EXPECT_TRUE(left_out_by(plan_of(kPaint), "lambert"));
}

TEST(Plan, OneRoughnessIsARowAtExactlyThatRoughness) {
    for (const double roughness : {0.0001, 0.4, 0.7, 1.0}) {
        const ScenePlan plan =
            plan_of(R"({"lobes":["metal"],"roughness":)" + std::to_string(roughness) + "}");
        EXPECT_TRUE(left_out_by(plan, "row"));
        const JobSpec& job = plan.tables.at(0).job;
        EXPECT_EQ(job.resolution, (std::vector<std::int64_t>{64, 1}));
        EXPECT_EQ(axis_value(job.axes[1], 0, 1), roughness);
        EXPECT_EQ(plan.tables.at(1).job.resolution, (std::vector<std::int64_t>{1}));
    }
}

TEST(Plan, ARangeIsAnAxisOverIt) {
    const ScenePlan plan = plan_of(kPaint);
    EXPECT_TRUE(left_out_by(plan, "range"));
    const JobSpec& job = plan.tables.at(0).job;
    EXPECT_EQ(axis_value(job.axes[1], 0, job.resolution[1]), 0.2);
    EXPECT_EQ(axis_value(job.axes[1], job.resolution[1] - 1, job.resolution[1]), 0.6);
}

TEST(Plan, OneReflectanceIsOneChannel) {
    PlanOptions options;
    for (const auto multiscatter :
         {Multiscatter::none, Multiscatter::kulla_conty, Multiscatter::turquin}) {
        options.multiscatter = multiscatter;
        const ScenePlan plan = plan_of(kPaint, options);
        EXPECT_TRUE(left_out_by(plan, "one_reflectance"));
        ASSERT_EQ(plan.tables.size(), 1u);
        EXPECT_EQ(plan.tables[0].job.quantities,
                  (std::vector{multiscatter == Multiscatter::none ? Quantity::specular_albedo
                                                                  : Quantity::compensated_albedo}));
        EXPECT_EQ(plan.tables[0].job.fresnel.f0, (std::vector<double>{0.04}));
    }
    const ScenePlan white = plan_of(R"({"lobes":["metal"],"roughness":0.5,"metal_f0":1})");
    EXPECT_EQ(white.tables.at(0).job.quantities, (std::vector{Quantity::directional_albedo}));
    EXPECT_TRUE(left_out_by(white, "average"));
    EXPECT_FALSE(left_out_by(plan_of(kMetal), "one_reflectance"));
}

TEST(Plan, InvisibleCompensationIsNotComputed) {
    PlanOptions options;
    options.pixel = PixelType::uint8;
    options.format = ImageFormat::png;
    const ScenePlan plan = plan_of(kPaint, options);
    EXPECT_TRUE(left_out_by(plan, "multiscatter"));
    EXPECT_EQ(plan.tables.at(0).job.quantities, (std::vector{Quantity::specular_albedo}));
    EXPECT_FALSE(left_out_by(plan_of(kPaint), "multiscatter"));
    EXPECT_FALSE(left_out_by(plan_of(kMetal, options), "multiscatter"));
}

TEST(Plan, AMirrorIsAClosedFormUnlessATableHasItsRow) {
    const std::string mirror = R"({"lobes":["metal"],"roughness":0})";
    const ScenePlan alone = plan_of(mirror);
    EXPECT_TRUE(alone.tables.empty());
    EXPECT_TRUE(left_out_by(alone, "mirror"));
    EXPECT_EQ(alone.materials[0].lobes.at(0).reading, Reading::closed_form);
    const ScenePlan among = plan_of(mirror + R"(,{"lobes":["metal"],"roughness":[0,0.3]})");
    EXPECT_FALSE(left_out_by(among, "mirror"));
    EXPECT_EQ(among.tables.at(0).serves.size(), 2u);
}

TEST(Plan, EqualTablesAreOne) {
    const ScenePlan plan = plan_of(std::string(kMetal) + "," + kMetal +
                                   R"(,{"lobes":["clearcoat"],"clearcoat_roughness":0.4})");
    EXPECT_EQ(names_of(plan), "specular average");
    EXPECT_EQ(plan.tables[0].serves.size(), 3u);
    EXPECT_TRUE(left_out_by(plan, "equal"));
}

std::string measured(char digit, const std::string& more = "") {
    return R"({"measured":")" + test::measurement(digit) + "\"" + more + "}";
}

TEST(Plan, MeasuredDataThatNothingUsesIsNotInTheAtlas) {
    const ScenePlan plan =
        plan_of(measured('b') + "," + measured('c', R"(,"used":false)") + "," + measured('a'));
    EXPECT_EQ(names_of(plan), "atlas");
    EXPECT_EQ(plan.tables[0].job.kind, Kind::atlas);
    const auto& cells = plan.tables[0].job.measured.materials;
    ASSERT_EQ(cells.size(), 2u);
    EXPECT_EQ(cells[0].data, std::string(64, 'a'));
    EXPECT_EQ(cells[1].data, std::string(64, 'b'));
    EXPECT_EQ(plan.materials[0].measured.value().cell, 1u);
    EXPECT_TRUE(left_out_by(plan, "measured"));
    EXPECT_TRUE(plan.unserved.empty());
    EXPECT_EQ(plan.full.back().job.measured.materials.size(), 3u);
    EXPECT_TRUE(contract_problems("Plan", to_json(plan)).empty());
    // Four by four places for 13 slices of 361 x 181 texels of two cells, four half floats each.
    EXPECT_EQ(plan.tables[0].estimate.bytes, 16u * 361 * 181 * 2 * 4 * 2);
}

TEST(Plan, EqualMeasuredDataIsOneCellAndNoNameOrOrderMakesAnotherAtlas) {
    const ScenePlan plan = plan_of(measured('a') + "," + measured('a') + "," + measured('b'));
    EXPECT_EQ(plan.tables.at(0).job.measured.materials.size(), 2u);
    EXPECT_EQ(plan.tables[0].serves.size(), 3u);
    EXPECT_TRUE(left_out_by(plan, "equal"));
    const ScenePlan other = plan_of(measured('b', R"(,"name":"felt")") + "," + measured('a'));
    EXPECT_EQ(other.tables.at(0).id, plan.tables[0].id);
    EXPECT_FALSE(left_out_by(other, "equal"));
}

TEST(Plan, SlicesLieInTheAtlasWhereTheManifestSays) {
    const ScenePlan plan = plan_of(measured('a') + "," + measured('b'));
    const auto slices = slice_lookups(plan.tables.at(0).job, 1);
    // 0 to 60 degrees by 5, four in a row, each of two cells of 361 x 181: 2888 x 724 texels.
    ASSERT_EQ(slices.size(), 13u);
    EXPECT_EQ(slices[7].theta_in, 35);
    const auto texel = [](const AngleLookup& along, double angle, double size) {
        return (along.scale * angle + along.offset) * size - 0.5;
    };
    const double pi = std::acos(-1.0);
    EXPECT_NEAR(texel(slices[0].phi_d, 0, 2888), 361, 1e-9);
    EXPECT_NEAR(texel(slices[7].phi_d, 0, 2888), 7 * 361, 1e-9);
    EXPECT_NEAR(texel(slices[7].phi_d, 2 * pi, 2888), 7 * 361 + 360, 1e-9);
    EXPECT_NEAR(texel(slices[7].theta_d, 0, 724), 181, 1e-9);
    EXPECT_NEAR(texel(slices[7].theta_d, pi, 724), 361, 1e-9);
}

TEST(Plan, AnAtlasKeepsWhatIsBrighterThanOneAndNoMoreThanAJobMay) {
    PlanOptions options;
    options.format = ImageFormat::png;
    options.pixel = PixelType::uint8;
    std::string many;
    for (int i = 0; i < 300; ++i) {
        const std::string number = std::to_string(1000 + i);
        many +=
            (i ? ",{" : "{") + (R"("measured":"sha256:)" + std::string(60, '0') + number) + "\"}";
    }
    const ScenePlan plan = plan_of(many, options);
    std::size_t cells = 0;
    for (const PlannedTable& table : plan.tables) {
        EXPECT_EQ(table.job.pixel, PixelType::rgb9e5);
        EXPECT_EQ(parse_job(canonical(table.job)), table.job);
        cells += table.job.measured.materials.size();
    }
    EXPECT_EQ(cells, 300u);
    EXPECT_GT(plan.tables.size(), 1u);
    for (const MaterialPlan& material : plan.materials) EXPECT_TRUE(material.measured);
}

TEST(Plan, UnlitNeedsNothing) {
    const ScenePlan plan = plan_of("{}");
    EXPECT_TRUE(plan.tables.empty());
    for (const char* rule : {"unlit", "no_specular", "no_sheen", "no_diffuse"})
        EXPECT_TRUE(left_out_by(plan, rule)) << rule;
}

TEST(Plan, WhatNoTableServesIsSaid) {
    const ScenePlan plan = plan_of(
        R"({"lobes":["dielectric","transmission","anisotropy","iridescence"],"roughness":0.5})");
    EXPECT_EQ(plan.unserved.size(), 3u);
    EXPECT_FALSE(left_out_by(plan, "one_reflectance"));
}

const char* const kMany =
    R"({"name":"a","lobes":["metal","sheen"],"sheen_roughness":0.5,"roughness":0.7},
       {"name":"b","lobes":["dielectric","diffuse","clearcoat"],"roughness":[0.1,0.5],
        "clearcoat_roughness":0.05})";

TEST(Plan, EveryLobeReadsSomethingAndEveryTableIsRead) {
    for (const char* diffuse : {"lambert", "burley"})
        for (const char* multiscatter : {"none", "kulla_conty", "turquin"}) {
            const PlanRequest request =
                read_plan_request({{"diffuse", diffuse}, {"multiscatter", multiscatter}});
            const ScenePlan plan = plan_of(kMany, request.options);
            std::map<std::size_t, std::size_t> readers;
            std::size_t lobes = 0;
            for (const MaterialPlan& material : plan.materials)
                for (const LobePlan& lobe : material.lobes) {
                    ++lobes;
                    if (lobe.table) ++readers[*lobe.table];
                    if (lobe.average) ++readers[*lobe.average];
                }
            EXPECT_EQ(lobes, 5u);
            EXPECT_EQ(readers.size(), plan.tables.size());
            for (std::size_t i = 0; i < plan.tables.size(); ++i)
                EXPECT_EQ(readers[i], plan.tables[i].serves.size()) << plan.tables[i].name;
        }
}

TEST(Plan, JobsAreOrdinaryDocumentsWithTheirIds) {
    const ScenePlan plan = plan_of(kMany);
    for (const PlannedTable& table : plan.tables) {
        const std::string text = canonical(table.job);
        EXPECT_EQ(parse_job(text), table.job);
        EXPECT_EQ(job_id(parse_job(text)), table.id);
    }
    EXPECT_TRUE(contract_problems("Plan", to_json(plan)).empty());
}

/// The engine counts what it does; a plan says the same number before.
TEST(Plan, EstimatesAreWhatTheEngineCounts) {
    PlanOptions options;
    options.resolution = 8;
    options.sample_count = 64;
    options.diffuse = DiffuseModel::burley;
    options.device = DeviceChoice::native;
    EngineOptions native;
    native.device = DeviceChoice::native;
    Engine engine(native);
    std::size_t drawn_twice = 0;
    for (const auto multiscatter : {Multiscatter::none, Multiscatter::kulla_conty,
                                    Multiscatter::kulla_conty_linear, Multiscatter::turquin}) {
        options.multiscatter = multiscatter;
        const ScenePlan plan = plan_of(kMany, options);
        std::vector<PlannedTable> tables = plan.tables;
        tables.insert(tables.end(), plan.full.begin(), plan.full.end());
        EXPECT_GE(tables.size(), 4u + 3u);
        for (const PlannedTable& table : tables) {
            const Outcome outcome = engine.run(table.job, Control{});
            const std::uint64_t estimate = table.estimate.evaluations;
            const Work& work = outcome.report.work;
            EXPECT_EQ(work.brdf_evaluations, estimate) << table.name;
            std::uint64_t values = 0;
            for (const auto& plane : outcome.table.planes) values += plane.size();
            EXPECT_EQ(2 * values, table.estimate.bytes);
            const bool deficit = table.job.quantities[0] == Quantity::compensated_albedo &&
                                 multiscatter != Multiscatter::turquin;
            // An average draws 1 - E by itself where that is expected below .03.
            std::uint64_t apart = 0;
            if (table.job.quantities[0] == Quantity::average_albedo)
                for (std::size_t i = 0; i < outcome.table.planes[0].size(); ++i) {
                    const double alpha = Places::averaged(table.job).alpha(i);
                    if (better_apart(alpha, expected_average_deficit(alpha), true)) apart += 64;
                }
            EXPECT_EQ(work.multiscatter_evaluations, deficit ? work.brdf_evaluations : apart);
            drawn_twice += estimate > 64 * values && table.job.resolution.size() > 1;
        }
    }
    EXPECT_GT(drawn_twice, 0u);
}

/// The example of the documentation.
TEST(Plan, TheKitchen) {
    std::ifstream file(KILN_SOURCE_DIR "/examples/scenes/kitchen.gltf", std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    const ScenePlan plan = plan_scene(read_scene(text, {}), {});
    ASSERT_EQ(plan.scene.materials.size(), 4u);
    // The oak's texels, 115 to 191 of 255.
    EXPECT_EQ(plan.scene.materials[0].roughness, (Range{115 / 255.0, 191 / 255.0, Origin::texels}));
    EXPECT_EQ(plan.scene.materials[0].metallic.hi, 0);
    ASSERT_EQ(plan.scene.unused.size(), 1u);
    EXPECT_EQ(plan.scene.unused[0].name, "rust");
    EXPECT_TRUE(plan.scene.warnings.empty());
    EXPECT_EQ(names_of(plan), "specular specular_2 average specular_3 specular_4 sheen");
}

TEST(PlanOptions, AreReadFromTextAndRefusedByName) {
    const PlanRequest request = read_plan_request(
        {{"resolution", "32"}, {"format", "png"}, {"scene", "7"}, {"variant", "red"}});
    EXPECT_EQ(request.options.resolution, 32);
    EXPECT_EQ(request.options.pixel, PixelType::uint16);
    EXPECT_EQ(request.choice.scene, "7");
    EXPECT_EQ(read_plan_request({}).options.multiscatter, Multiscatter::kulla_conty);
    const std::map<std::string, std::string> wrong[] = {
        {{"resolution", "1"}},
        {{"resolution", "x"}},
        {{"resolution", "4097"}},
        {{"sample_count", "-1"}},
        {{"colour", "red"}},
        {{"multiscatter", "all"}},
        {{"diffuse", ""}},
        {{"pixel", "uint8"}},
        {{"format", "png"}, {"pixel", "half"}},
        {{"resolution", "1024"}, {"sample_count", "1048576"}}};
    for (const auto& options : wrong) {
        try {
            read_plan_request(options);
            ADD_FAILURE() << options.begin()->first << "=" << options.begin()->second;
        } catch (const Error& error) {
            EXPECT_EQ(error.code(), "bad_query");
        }
    }
}

}  // namespace
}  // namespace kiln
