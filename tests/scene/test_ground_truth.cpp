// SPDX-License-Identifier: Apache-2.0
// Public glTF scenes with what they need, found by hand from the specification. The folder is not
// part of the project: KILN_SCENES names it, or it lies beside the project.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>

#include "server/scene/scene.h"

namespace kiln {
namespace {

using Numbers = std::set<double>;

struct Truth {
    std::string file{};
    std::string lobes{};  ///< in the order of the enumerators
    bool unlit = false;
    std::size_t scene = 0, scene_count = 1;
    std::set<int> used{};  ///< −1: the default material
    std::set<std::size_t> variant_only{};
    // Of base layers: values of factors, and whether a texture makes it [0, 1].
    Numbers roughness{};
    bool roughness_texture = false;
    Numbers metallic{};
    double metallic_texture = -1;  ///< upper end of the texture's range
    std::string ior{};
    std::vector<std::array<double, 3>> metal_f0{};  ///< upper bounds
    bool metal_textured = false;
    std::vector<std::array<double, 3>> dielectric_f0{};
    Numbers sheen{}, coat{};
    bool sheen_texture = false, coat_texture = false;
};

const std::array<double, 3> kWhite{1, 1, 1}, kFour{0.04, 0.04, 0.04};

std::vector<Truth> layered_truths() {
    std::vector<Truth> all;
    all.push_back({.file = "UnlitTest.gltf", .lobes = "", .unlit = true, .used = {0, 1}});
    all.push_back({.file = "SheenCloth.gltf",
                   .lobes = "metal dielectric diffuse sheen",
                   .used = {0},
                   .roughness_texture = true,
                   .metallic_texture = 1,
                   .ior = "1.5",
                   .metal_f0 = {kWhite},
                   .metal_textured = true,
                   .dielectric_f0 = {kFour},
                   .sheen_texture = true});
    Truth coat{.file = "ClearCoatTest.gltf", .lobes = "dielectric diffuse clearcoat"};
    for (int i = 0; i < 19; ++i) coat.used.insert(i);
    coat.roughness = {0.029999999329447746, 0.4399999976158142, 0.6000000238418579,
                      0.8999999761581421};
    coat.roughness_texture = true;
    coat.metallic = {0};
    coat.metallic_texture = 0;
    coat.ior = "1.5";
    coat.dielectric_f0 = {kFour};
    coat.coat = {0.03};
    coat.coat_texture = true;
    all.push_back(coat);
    all.push_back({.file = "AnisotropyBarnLamp.gltf",
                   .lobes = "metal dielectric diffuse clearcoat transmission anisotropy",
                   .used = {0, 1, 2},
                   .roughness = {0, 0.7},
                   .roughness_texture = true,
                   .metallic = {0},
                   .metallic_texture = 1,
                   .ior = "1.5",
                   .metal_f0 = {kWhite},
                   .metal_textured = true,
                   .dielectric_f0 = {kFour},
                   .coat = {0.15}});
    return all;
}

std::vector<Truth> truths() {
    std::vector<Truth> all = layered_truths();
    all.push_back({.file = "SpecGlossVsMetalRough.gltf",
                   .lobes = "metal dielectric specular_glossiness diffuse",
                   .used = {0, 1, 2, 3},
                   .roughness = {1},
                   .roughness_texture = true,
                   .metallic = {0},
                   .metallic_texture = 1,
                   .ior = "1.5",
                   .metal_f0 = {kWhite},
                   .metal_textured = true,
                   .dielectric_f0 = {kFour}});
    all.push_back({.file = "GlamVelvetSofa.gltf",
                   .lobes = "metal dielectric diffuse sheen",
                   .used = {0, 1, 3},
                   .variant_only = {2, 4, 5, 6},
                   .roughness = {0.4, 0.7},
                   .metallic = {0, 1},
                   .ior = "1.5",
                   .metal_f0 = {{1, 0.8, 0.7}},
                   .dielectric_f0 = {kFour, {0.004, 0.0136, 0.04}},
                   .sheen = {0.6}});
    all.push_back({.file = "DiffuseTransmissionTeacup.gltf",
                   .lobes = "metal dielectric diffuse diffuse_transmission",
                   .used = {0, 1},
                   .roughness_texture = true,
                   .metallic_texture = 1,
                   .ior = "1.5",
                   .metal_f0 = {kWhite},
                   .metal_textured = true,
                   .dielectric_f0 = {kFour}});
    const Truth white{
        .lobes = "metal", .used = {0}, .roughness = {1}, .metallic = {1}, .metal_f0 = {kWhite}};
    for (const char* file :
         {"00-metal-roughness-0.40.gltf", "MultipleScenes.gltf", "Compatibility_05.gltf"}) {
        all.push_back(white);
        all.back().file = file;
    }
    all[all.size() - 3].roughness = {0.4};
    all[all.size() - 2].used = {-1};
    all[all.size() - 2].scene = 1;
    all[all.size() - 2].scene_count = 2;
    return all;
}

std::string lobes_of(const SceneUse& scene) {
    LobeSet lobes;
    for (const MaterialUse& material : scene.materials) lobes.add(material.lobes);
    std::string text;
    for (std::size_t i = 0; i < kLobeCount; ++i)
        if (lobes.has(static_cast<Lobe>(i)))
            text += (text.empty() ? "" : " ") + std::string(to_word(static_cast<Lobe>(i)));
    return text;
}

/// What the materials that have one of `lobes` take: values of factors, and whether some texture
/// makes it a range.
struct Taken {
    Numbers values;
    double texture_hi = -1;
    void add(const Range& range) {
        if (range.origin == Origin::factor) {
            EXPECT_EQ(range.lo, range.hi);
            values.insert(range.lo);
        } else {
            EXPECT_EQ(range.origin, Origin::texture);  // no image is in the documents
            EXPECT_EQ(range.lo, 0);
            texture_hi = std::max(texture_hi, range.hi);
        }
    }
};

bool has_any(const MaterialUse& material, std::initializer_list<Lobe> lobes) {
    return std::any_of(lobes.begin(), lobes.end(),
                       [&](Lobe lobe) { return material.lobes.has(lobe); });
}

void expect_taken(const Taken& taken, const Numbers& values, double texture_hi) {
    EXPECT_EQ(taken.values, values);
    EXPECT_EQ(taken.texture_hi, texture_hi);
}

void expect_ranges(const SceneUse& scene, const Truth& truth) {
    Taken roughness, metallic, sheen, coat;
    for (const MaterialUse& material : scene.materials) {
        if (has_any(material, {Lobe::metal, Lobe::dielectric, Lobe::specular_glossiness}))
            roughness.add(material.roughness);
        if (has_any(material, {Lobe::metal, Lobe::dielectric})) metallic.add(material.metallic);
        if (has_any(material, {Lobe::sheen})) sheen.add(material.sheen_roughness);
        if (has_any(material, {Lobe::clearcoat})) coat.add(material.clearcoat_roughness);
    }
    SCOPED_TRACE("roughness");
    expect_taken(roughness, truth.roughness, truth.roughness_texture ? 1 : -1);
    expect_taken(metallic, truth.metallic, truth.metallic_texture);
    expect_taken(sheen, truth.sheen, truth.sheen_texture ? 1 : -1);
    expect_taken(coat, truth.coat, truth.coat_texture ? 1 : -1);
}

/// Each colour of the truth is that of some material, and each material's that of the truth.
void expect_colours(const std::vector<ColourRange>& found,
                    const std::vector<std::array<double, 3>>& truth, bool textured) {
    std::set<std::size_t> met;
    for (const ColourRange& colour : found) {
        bool any = false;
        for (std::size_t i = 0; i < truth.size(); ++i) {
            bool same = true;
            for (std::size_t c = 0; c < 3; ++c) {
                // Rule 9 multiplies doubles; another order of the factors may round differently.
                same &= std::abs(colour[c].hi - truth[i][c]) <= 1e-15;
                same &= textured ? colour[c].origin == Origin::texture && colour[c].lo == 0
                                 : colour[c].fixed();
            }
            any |= same;
            if (same) met.insert(i);
        }
        EXPECT_TRUE(any) << colour[0].hi << " " << colour[1].hi << " " << colour[2].hi;
    }
    EXPECT_EQ(met.size(), truth.size());
}

std::filesystem::path scenes_folder() {
    const char* given = std::getenv("KILN_SCENES");
    const std::filesystem::path folder = given ? given : KILN_SOURCE_DIR "/../shared/data/scenes";
    return std::filesystem::exists(folder) ? folder : "";
}

TEST(GroundTruth, EverySceneIsMetExactly) {
    const std::filesystem::path folder = scenes_folder();
    if (folder.empty()) GTEST_SKIP() << "no folder of public scenes; KILN_SCENES may name one";
    for (const Truth& truth : truths()) {
        SCOPED_TRACE(truth.file);
        std::ifstream file(folder / truth.file, std::ios::binary);
        ASSERT_TRUE(file.good());
        const std::string text{std::istreambuf_iterator<char>(file), {}};
        const SceneUse scene = read_scene(text, {});
        EXPECT_EQ(lobes_of(scene), truth.lobes);
        EXPECT_EQ(scene.scene, truth.scene);
        EXPECT_EQ(scene.scene_count, truth.scene_count);
        std::set<int> used;
        std::vector<ColourRange> metal, dielectric;
        for (const MaterialUse& material : scene.materials) {
            used.insert(material.index ? static_cast<int>(*material.index) : -1);
            EXPECT_EQ(material.unlit, truth.unlit);
            if (material.lobes.has(Lobe::metal)) metal.push_back(material.metal_f0);
            if (!material.lobes.has(Lobe::dielectric)) continue;
            dielectric.push_back(material.f0);
            EXPECT_EQ(material.ior, std::stod(truth.ior));
            EXPECT_EQ(material.f90, (Range{1, 1}));
        }
        EXPECT_EQ(used, truth.used);
        std::set<std::size_t> unused;
        for (const UnusedMaterial& material : scene.unused) {
            unused.insert(material.index);
            EXPECT_EQ(material.why, "only a material variant names it");
        }
        EXPECT_EQ(unused, truth.variant_only);
        expect_ranges(scene, truth);
        expect_colours(metal, truth.metal_f0, truth.metal_textured);
        expect_colours(dielectric, truth.dielectric_f0, false);
        const bool invented = truth.file == "Compatibility_05.gltf";
        EXPECT_EQ(scene.warnings.size(), invented ? 1u : 0u);
    }
}

struct LobeRoughness {
    std::string file;
    Lobe lobe;
    Numbers values{};      ///< of factors
    bool texture = false;  ///< and all of [0, 1]
};

/// Every lobe of every scene that has a roughness.
std::vector<LobeRoughness> roughness_by_lobe() {
    using enum Lobe;
    const Numbers coats = {0.029999999329447746, 0.4399999976158142, 0.6000000238418579,
                           0.8999999761581421};
    return {{"SheenCloth.gltf", metal, {}, true},
            {"SheenCloth.gltf", dielectric, {}, true},
            {"SheenCloth.gltf", sheen, {}, true},
            {"ClearCoatTest.gltf", dielectric, coats, true},
            {"ClearCoatTest.gltf", clearcoat, {0.03}, true},
            {"AnisotropyBarnLamp.gltf", metal, {}, true},
            {"AnisotropyBarnLamp.gltf", dielectric, {0, 0.7}, true},
            {"AnisotropyBarnLamp.gltf", transmission, {0}},
            {"AnisotropyBarnLamp.gltf", clearcoat, {0.15}},
            {"SpecGlossVsMetalRough.gltf", metal, {}, true},
            {"SpecGlossVsMetalRough.gltf", dielectric, {1}, true},
            // Material 3 has a factor and no texture: 1 − 0.
            {"SpecGlossVsMetalRough.gltf", specular_glossiness, {1}, true},
            {"GlamVelvetSofa.gltf", metal, {0.4}},
            {"GlamVelvetSofa.gltf", dielectric, {0.4, 0.7}},
            {"GlamVelvetSofa.gltf", sheen, {0.6}},
            {"DiffuseTransmissionTeacup.gltf", metal, {}, true},
            {"DiffuseTransmissionTeacup.gltf", dielectric, {}, true},
            {"00-metal-roughness-0.40.gltf", metal, {0.4}},
            {"MultipleScenes.gltf", metal, {1}},
            {"Compatibility_05.gltf", metal, {1}}};
}

TEST(GroundTruth, RoughnessByLobe) {
    const std::filesystem::path folder = scenes_folder();
    if (folder.empty()) GTEST_SKIP() << "no folder of public scenes; KILN_SCENES may name one";
    const std::vector<LobeRoughness> truth = roughness_by_lobe();
    std::size_t met = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
        if (entry.path().extension() != ".gltf") continue;
        std::ifstream file(entry.path(), std::ios::binary);
        const SceneUse scene =
            read_scene(std::string(std::istreambuf_iterator<char>(file), {}), {});
        for (const Lobe lobe : {Lobe::metal, Lobe::dielectric, Lobe::specular_glossiness,
                                Lobe::transmission, Lobe::sheen, Lobe::clearcoat}) {
            Taken taken;
            bool any = false;
            for (const MaterialUse& material : scene.materials) {
                if (!material.lobes.has(lobe)) continue;
                any = true;
                taken.add(lobe == Lobe::sheen       ? material.sheen_roughness
                          : lobe == Lobe::clearcoat ? material.clearcoat_roughness
                                                    : material.roughness);
            }
            SCOPED_TRACE(entry.path().filename().string() + " " + std::string(to_word(lobe)));
            const auto row = std::find_if(truth.begin(), truth.end(), [&](const auto& known) {
                return known.file == entry.path().filename() && known.lobe == lobe;
            });
            EXPECT_EQ(any, row != truth.end());
            if (row == truth.end()) continue;
            ++met;
            expect_taken(taken, row->values, row->texture ? 1 : -1);
        }
    }
    EXPECT_EQ(met, truth.size());
}

// The row of GlamVelvetSofa.gltf over all variants.
TEST(GroundTruth, VariantsOnRequest) {
    const std::filesystem::path folder = scenes_folder();
    if (folder.empty()) GTEST_SKIP() << "no folder of public scenes; KILN_SCENES may name one";
    std::ifstream file(folder / "GlamVelvetSofa.gltf", std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    const SceneUse scene = read_scene(text, {.scene = "", .variant = "all"});
    EXPECT_TRUE(scene.unused.empty());
    Numbers roughness, sheen;
    for (const MaterialUse& material : scene.materials) {
        roughness.insert(material.roughness.lo);
        if (material.lobes.has(Lobe::sheen)) sheen.insert(material.sheen_roughness.lo);
    }
    EXPECT_EQ(roughness, (Numbers{0.4, 0.5, 0.7, 0.75, 1}));
    EXPECT_EQ(sheen, (Numbers{0.3, 0.6, 0.85, 1}));
}

}  // namespace
}  // namespace kiln
