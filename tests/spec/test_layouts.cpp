// SPDX-License-Identifier: Apache-2.0
#include "server/spec/layouts.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>

#include "server/spec/spec.h"

namespace kiln {
namespace {

using Json = nlohmann::json;

JobSpec job_of(const std::string& layout, const std::string& more = "") {
    return parse_job(R"({"quantities":["split_sum_scale","split_sum_bias"],"layout":")" + layout +
                     "\"" + more + "}");
}

TEST(Layouts, NamesAreTheContractsEnum) {
    const Json contract = Json::parse(openapi_text());
    std::vector<std::string> names;
    for (const LayoutPreset& preset : layout_presets()) names.push_back(preset.name);
    EXPECT_EQ(contract["components"]["schemas"]["Job"]["properties"]["layout"]["oneOf"][0]["enum"],
              names);
    EXPECT_EQ(layout_preset("custom"), nullptr);
}

TEST(Layouts, TheCanonicalFormKeepsTheName) {
    std::set<std::string> ids;
    for (const LayoutPreset& preset : layout_presets()) {
        const JobSpec job = job_of(preset.name);
        EXPECT_EQ(job.layout, preset.name);
        EXPECT_EQ(job.axes, preset.axes);
        EXPECT_EQ(Json::parse(canonical(job))["layout"], preset.name);
        EXPECT_EQ(parse_job(canonical(job)), job);
        ids.insert(job_id(job));
    }
    EXPECT_EQ(ids.size(), layout_presets().size());
}

TEST(Layouts, MaskingIsTheProgramsWhereTheDocumentNamesNone) {
    for (const char* name : {"kiln", "unity", "filament", "threejs", "babylon", "cycles", "gltf"})
        EXPECT_EQ(job_of(name).masking, Masking::smith_correlated) << name;
    EXPECT_EQ(job_of("unreal").masking, Masking::unreal_joint);
    EXPECT_EQ(job_of("godot").masking, Masking::karis_ibl);
    EXPECT_EQ(job_of("godot", R"(,"microfacet":{"distribution":"ggx"})").masking,
              Masking::karis_ibl);
}

/// As the contract writes it: "unity 64 x 64".
std::string size_in_words(const LayoutPreset& preset) {
    return std::to_string(preset.resolution[0]) + " x " + std::to_string(preset.resolution[1]);
}

TEST(Layouts, ResolutionIsTheProgramsWhereTheDocumentNamesNone) {
    const Json contract = Json::parse(openapi_text());
    const std::string told =
        contract["components"]["schemas"]["Job"]["properties"]["resolution"]["description"];
    for (const LayoutPreset& preset : layout_presets()) {
        const std::vector<std::int64_t> usual{256, 256};
        const bool own = !preset.resolution.empty();
        EXPECT_EQ(job_of(preset.name).resolution, own ? preset.resolution : usual) << preset.name;
        EXPECT_EQ(own, told.find(preset.name) != told.npos) << preset.name;
        EXPECT_EQ(job_of(preset.name, R"(,"resolution":[8,4])").resolution,
                  (std::vector<std::int64_t>{8, 4}));
        if (!own) continue;
        const std::string words = told.substr(told.find(preset.name));
        EXPECT_EQ(words.find(size_in_words(preset)), words.find_first_of("0123456789"))
            << preset.name;
    }
    // As the published tables are: facts of the programs.
    EXPECT_EQ(job_of("unreal").resolution, (std::vector<std::int64_t>{128, 32}));
    EXPECT_EQ(job_of("threejs").resolution, (std::vector<std::int64_t>{16, 16}));
    // Cycles' E_avg is a table of its own.
    EXPECT_EQ(parse_job(R"({"quantities":["average_albedo"],"layout":"cycles"})").resolution,
              (std::vector<std::int64_t>{32}));
    // An object with the axes of a preset is no preset.
    EXPECT_EQ(parse_job(R"({"quantities":["directional_albedo"],"layout":{"x":{"parameter":)"
                        R"("roughness"},"y":{"parameter":"NoV"}}})")
                  .resolution,
              (std::vector<std::int64_t>{256, 256}));
}

TEST(Layouts, WhatTheDocumentSaysStays) {
    const JobSpec given =
        job_of("godot", R"(,"microfacet":{"masking":"smith_correlated"},"importance":"cosine")");
    EXPECT_EQ(given.masking, Masking::smith_correlated);
    EXPECT_EQ(given.importance, Importance::cosine);
    EXPECT_EQ(parse_job(canonical(given)), given);
    EXPECT_EQ(job_of("godot", R"(,"microfacet":{"distribution":"charlie"})").masking,
              Masking::neubelt);
    EXPECT_EQ(job_of("unreal", R"(,"microfacet":{"distribution":"beckmann"})").masking,
              Masking::smith_correlated);
}

TEST(Layouts, OneEntryIsKilnsAndCycles) {
    const std::string averages = R"({"quantities":["average_albedo"],"resolution":[32],"layout":)";
    for (const char* name : {"kiln", "cycles"}) {
        const JobSpec job = parse_job(averages + "\"" + name + "\"}");
        ASSERT_EQ(job.axes.size(), 1u);
        EXPECT_EQ(job.axes[0], layout_preset(name)->single_axis);
        EXPECT_EQ(parse_job(canonical(job)), job);
    }
    try {
        parse_job(averages + "\"filament\"}");
        ADD_FAILURE() << "a table of one entry was taken";
    } catch (const InvalidJob& refused) {
        ASSERT_EQ(refused.problems.size(), 1u);
        EXPECT_EQ(refused.problems[0].pointer, "/resolution");
        EXPECT_EQ(refused.problems[0].message,
                  "has one entry; layout \"filament\" is a table of two, [x, y]");
    }
}

TEST(Layouts, AnObjectIsNoPresetButKilns) {
    const auto object = [](const std::string& x, const std::string& y) {
        return parse_job(R"({"quantities":["directional_albedo"],"layout":{"x":{"parameter":")" +
                         x + R"("},"y":{"parameter":")" + y + "\"}}}")
            .layout;
    };
    EXPECT_EQ(object("roughness", "NoV"), "custom");  // three.js' axes
    EXPECT_EQ(object("NoV", "roughness"), "kiln");    // glTF's, too
}

TEST(Layouts, WarnsWhereTheTableDepartsFromTheProgram) {
    for (const LayoutPreset& preset : layout_presets()) {
        EXPECT_EQ(layout_lines(job_of(preset.name)).empty(), preset.name == "kiln") << preset.name;
        for (const ChannelSet& set : preset.channel_sets) {
            JobSpec job = job_of(preset.name);
            job.quantities = set.quantities;
            if (set.diffuse) job.diffuse.model = *set.diffuse;
            EXPECT_TRUE(layout_warnings(job).empty()) << preset.name;
        }
    }
    EXPECT_TRUE(layout_warnings(job_of("kiln")).empty());
    EXPECT_EQ(layout_warnings(job_of("godot", R"(,"microfacet":{"masking":"smith_correlated"})")),
              (std::vector<std::string>{
                  "layout \"godot\": the program was made for masking karis_ibl, this table has "
                  "smith_correlated",
                  "layout \"godot\": the program reads R = split_sum_bias, G = "
                  "directional_albedo, B = sheen_albedo; or R = split_sum_bias, G = "
                  "directional_albedo, this table has others"}));
    JobSpec unity = job_of("unity");
    unity.quantities = layout_preset("unity")->channel_sets[1].quantities;
    EXPECT_EQ(layout_warnings(unity).size(), 1u) << "Lambert in place of Burley";
    EXPECT_EQ(added_by_shader(unity, Quantity::diffuse_albedo), 0.5);
    unity.diffuse.albedo = {0.5, 0.2, 0.9};
    EXPECT_EQ(added_by_shader(unity, Quantity::diffuse_albedo), 0) << "five channels";
    // Another distribution, a table of its own.
    EXPECT_TRUE(
        layout_warnings(job_of("godot", R"(,"microfacet":{"distribution":"charlie"})")).empty());
}

}  // namespace
}  // namespace kiln
