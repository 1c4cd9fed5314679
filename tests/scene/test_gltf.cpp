// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "server/scene/scene.h"
#include "server/scene/texels.h"
#include "tests/scene/scenes.h"

namespace kiln {
namespace {

using test::scene_of;

MaterialUse only(const std::string& scene, const SceneChoice& choice = {}) {
    const SceneUse use = read_scene(scene, choice);
    EXPECT_EQ(use.materials.size(), 1u);
    return use.materials.at(0);
}

MaterialUse extended(const std::string& name, const std::string& members,
                     const std::string& base = R"("metallicFactor":0)") {
    return only(scene_of(R"({"pbrMetallicRoughness":{)" + base +
                         R"(},"extensions":{"KHR_materials_)" + name + R"(":{)" + members + "}}}"));
}

std::string lobes_of(const MaterialUse& use) {
    std::string text;
    for (std::size_t i = 0; i < kLobeCount; ++i)
        if (use.lobes.has(static_cast<Lobe>(i)))
            text += (text.empty() ? "" : " ") + std::string(to_word(static_cast<Lobe>(i)));
    return text;
}

/// A binary scene whose material has `material`, textures 0… of these images.
std::string packed(const std::string& material, const std::vector<std::string>& images) {
    std::string textures, list, views, binary;
    for (std::size_t i = 0; i < images.size(); ++i) {
        const std::string comma = i ? "," : "", index = std::to_string(i);
        textures += comma + R"({"source":)" + index + "}";
        list += comma + R"({"mimeType":"image/png","bufferView":)" + index + "}";
        views += comma + R"({"buffer":0,"byteOffset":)" + std::to_string(binary.size()) +
                 R"(,"byteLength":)" + std::to_string(images[i].size()) + "}";
        binary += images[i];
    }
    return test::glb_of(
        scene_of(material, R"("textures":[)" + textures + R"(],"images":[)" + list +
                               R"(],"bufferViews":[)" + views + R"(],"buffers":[{"byteLength":)" +
                               std::to_string(binary.size()) + "}],"),
        binary);
}

std::string image(std::vector<unsigned char> first, std::vector<unsigned char> second) {
    first.insert(first.end(), second.begin(), second.end());
    return test::png_of(2, 1, first);
}

TEST(Gltf, DefaultsAreThoseOfTheSpecification) {
    const MaterialUse use = only(scene_of("{}"));
    EXPECT_EQ(lobes_of(use), "metal");
    EXPECT_EQ(use.roughness, (Range{1, 1}));
    EXPECT_EQ(use.metallic, (Range{1, 1}));
    EXPECT_EQ(use.metal_f0[0], (Range{1, 1}));
}

TEST(Gltf, MetallicDecidesOnLobes) {
    EXPECT_EQ(lobes_of(only(scene_of(R"({"pbrMetallicRoughness":{"metallicFactor":0}})"))),
              "dielectric diffuse");
    EXPECT_EQ(lobes_of(only(scene_of(R"({"pbrMetallicRoughness":{"metallicFactor":0.5}})"))),
              "metal dielectric diffuse");
}

TEST(Gltf, EachLayerNeedsAFactorAboveZero) {
    const struct {
        const char *name, *factor, *lobe;
    } layers[] = {{"clearcoat", "clearcoatFactor", "clearcoat"},
                  {"transmission", "transmissionFactor", "transmission"},
                  {"diffuse_transmission", "diffuseTransmissionFactor", "diffuse_transmission"},
                  {"anisotropy", "anisotropyStrength", "anisotropy"},
                  {"iridescence", "iridescenceFactor", "iridescence"}};
    for (const auto& layer : layers) {
        const std::string half = std::string("\"") + layer.factor + "\":0.5";
        const std::string none = std::string("\"") + layer.factor + "\":0";
        EXPECT_NE(lobes_of(extended(layer.name, half)).find(layer.lobe), std::string::npos);
        EXPECT_EQ(lobes_of(extended(layer.name, none)), "dielectric diffuse");
        EXPECT_EQ(lobes_of(extended(layer.name, "")), "dielectric diffuse");
    }
    EXPECT_EQ(lobes_of(extended("sheen", R"("sheenColorFactor":[0,0,0])")), "dielectric diffuse");
    const MaterialUse sheen =
        extended("sheen", R"("sheenColorFactor":[0,0,0.1],"sheenRoughnessFactor":0.25)");
    EXPECT_EQ(lobes_of(sheen), "dielectric diffuse sheen");
    EXPECT_EQ(sheen.sheen_roughness, (Range{0.25, 0.25}));
    EXPECT_TRUE(extended("unlit", "").unlit);
}

TEST(Gltf, WhatGoesThroughLeavesNoDiffuse) {
    EXPECT_EQ(lobes_of(extended("transmission", R"("transmissionFactor":1)")),
              "dielectric transmission");
    EXPECT_EQ(lobes_of(extended("diffuse_transmission", R"("diffuseTransmissionFactor":1)")),
              "dielectric diffuse_transmission");
}

TEST(Gltf, DielectricReflectanceFollowsIorAndSpecular) {
    // Rule: min(((ior − 1) / (ior + 1))² · colour, 1) · factor; F90 is the factor.
    EXPECT_NEAR(extended("ior", R"("ior":1.33)").f0[0].lo, 0.020059, 1e-6);
    EXPECT_EQ(extended("ior", R"("ior":0)").f0[1], (Range{1, 1}));
    const MaterialUse tinted =
        extended("specular", R"("specularFactor":0.5,"specularColorFactor":[0.1,1,50])");
    EXPECT_NEAR(tinted.f0[0].lo, 0.002, 1e-15);
    EXPECT_NEAR(tinted.f0[1].lo, 0.02, 1e-15);
    EXPECT_NEAR(tinted.f0[2].hi, 0.5, 1e-15);
    EXPECT_EQ(tinted.f90, (Range{0.5, 0.5}));
    EXPECT_EQ(lobes_of(extended("specular", R"("specularFactor":0)")), "diffuse");
    EXPECT_EQ(lobes_of(extended("specular", R"("specularColorFactor":[0,0,0])")),
              "dielectric diffuse");
}

TEST(Gltf, SpecularGlossinessIsItsOwnLobe) {
    const MaterialUse use = extended("pbrSpecularGlossiness",
                                     R"("glossinessFactor":0.25,"specularFactor":[0.5,0.25,0])");
    EXPECT_EQ(lobes_of(use), "specular_glossiness diffuse");
    EXPECT_EQ(use.roughness, (Range{0.75, 0.75}));
    EXPECT_EQ(use.f0[1], (Range{0.25, 0.25}));
    const MaterialUse textured = only(scene_of(
        R"({"extensions":{"KHR_materials_pbrSpecularGlossiness":{"glossinessFactor":0.25,
            "specularGlossinessTexture":{"index":0}}}})",
        R"("textures":[{}],)"));
    EXPECT_EQ(textured.roughness, (Range{0.75, 1, Origin::texture}));
}

TEST(Gltf, TexelsThatAreThereNarrowTheRanges) {
    const std::string both = R"({"pbrMetallicRoughness":{"roughnessFactor":0.5,
        "metallicRoughnessTexture":{"index":0}}})";
    const MaterialUse use = only(packed(both, {image({9, 51, 0, 255}, {7, 102, 0, 255})}));
    EXPECT_EQ(use.roughness.origin, Origin::texels);
    EXPECT_DOUBLE_EQ(use.roughness.lo, 0.1);
    EXPECT_DOUBLE_EQ(use.roughness.hi, 0.2);
    EXPECT_EQ(lobes_of(use), "dielectric diffuse");  // no texel is metal
    EXPECT_TRUE(use.notes.empty());
    EXPECT_EQ(lobes_of(only(packed(both, {image({0, 9, 255, 9}, {0, 9, 255, 9})}))), "metal");
    EXPECT_EQ(lobes_of(only(packed(both, {image({0, 9, 255, 9}, {0, 9, 254, 9})}))),
              "metal dielectric diffuse");
}

TEST(Gltf, ColoursOfTexturesAreSrgb) {
    const MaterialUse use = only(packed(
        R"({"pbrMetallicRoughness":{"baseColorFactor":[1,0.5,1,1],"baseColorTexture":{"index":0}}})",
        {image({255, 128, 0, 255}, {255, 64, 0, 255})}));
    EXPECT_EQ(use.metal_f0[0], (Range{1, 1, Origin::texels}));
    EXPECT_DOUBLE_EQ(use.metal_f0[1].lo, 0.5 * linear_from_srgb(64 / 255.0));
    EXPECT_DOUBLE_EQ(use.metal_f0[1].hi, 0.5 * linear_from_srgb(128 / 255.0));
    EXPECT_EQ(use.metal_f0[2].hi, 0);
}

TEST(Gltf, EachTextureIsReadFromItsOwnChannel) {
    const std::string codes = image({10, 20, 30, 40}, {10, 20, 30, 40});
    const MaterialUse use = only(packed(
        R"({"pbrMetallicRoughness":{"metallicFactor":0},"extensions":{
            "KHR_materials_sheen":{"sheenColorFactor":[1,1,1],"sheenRoughnessFactor":1,
                "sheenRoughnessTexture":{"index":0}},
            "KHR_materials_clearcoat":{"clearcoatFactor":1,"clearcoatRoughnessFactor":1,
                "clearcoatRoughnessTexture":{"index":0}},
            "KHR_materials_specular":{"specularTexture":{"index":0}}}})",
        {codes}));
    EXPECT_DOUBLE_EQ(use.sheen_roughness.lo, 40 / 255.0);
    EXPECT_DOUBLE_EQ(use.clearcoat_roughness.hi, 20 / 255.0);
    EXPECT_DOUBLE_EQ(use.f90.hi, 40 / 255.0);
    const std::string black = image({0, 255, 255, 255}, {0, 255, 255, 255});
    EXPECT_EQ(lobes_of(only(packed(R"({"pbrMetallicRoughness":{"metallicFactor":0},"extensions":{
            "KHR_materials_clearcoat":{"clearcoatFactor":1,"clearcoatTexture":{"index":0}}}})",
                                   {black}))),
              "dielectric diffuse");
}

// 70 x 2^20 texels are more than one scene has looked into, one time 2^20 are not.
TEST(Gltf, ImagesOfTheSameBytesAreLookedIntoOnce) {
    const std::string png =
        test::png_of(1024, 1024, std::vector<unsigned char>(std::size_t{4} << 20U, 51));
    std::string materials, primitives, textures, images;
    for (int i = 0; i < 70; ++i) {
        const std::string comma = i ? "," : "", index = std::to_string(i);
        materials += comma + R"({"pbrMetallicRoughness":{"metallicRoughnessTexture":{"index":)" +
                     index + "}}}";
        primitives += comma + R"({"material":)" + index + "}";
        textures += comma + R"({"source":)" + index + "}";
        images += comma + R"({"bufferView":0})";
    }
    const SceneUse use =
        read_scene(test::glb_of(R"({"asset":{"version":"2.0"},"meshes":[{"primitives":[)" +
                                    primitives + R"(]}],"materials":[)" + materials +
                                    R"(],"textures":[)" + textures + R"(],"images":[)" + images +
                                    R"(],"bufferViews":[{"buffer":0,"byteLength":)" +
                                    std::to_string(png.size()) + R"(}],"buffers":[{"byteLength":)" +
                                    std::to_string(png.size()) + "}]}",
                                png),
                   {});
    ASSERT_EQ(use.materials.size(), 70u);
    for (const MaterialUse& material : use.materials)
        EXPECT_EQ(material.roughness, (Range{0.2, 0.2, Origin::texels}));
}

TEST(Gltf, AnImageInAnotherFormatMayBeAnyValue) {
    const std::string scene =
        packed(R"({"pbrMetallicRoughness":{"metallicRoughnessTexture":{"index":0}}})",
               {image({9, 51, 0, 255}, {7, 102, 0, 255})});
    EXPECT_EQ(only(scene).roughness.origin, Origin::texels);
    std::string both = scene;
    const std::string source = R"({"source":0})";
    both.replace(both.find(source), source.size(),
                 R"({"source":0,"extensions":{"EXT_texture_webp":{}}})");
    both = test::glb_of(both.substr(20, both.find(std::string("BIN\0", 4)) - 24),
                        image({9, 51, 0, 255}, {7, 102, 0, 255}));
    EXPECT_EQ(only(both).roughness, (Range{0, 1, Origin::texture}));
}

TEST(Gltf, ASceneIsFoundByIndexBeforeName) {
    const std::string text = R"({"asset":{"version":"2.0"},"scenes":[{"name":"1"},{"name":"b"}]})";
    EXPECT_EQ(read_scene(text, {.scene = "1", .variant = ""}).scene, 1u);
    EXPECT_EQ(read_scene(text, {.scene = "b", .variant = ""}).scene, 1u);
}

TEST(Gltf, AnImageElsewhereIsEveryValueAndSaysSo) {
    const MaterialUse use =
        only(scene_of(R"({"pbrMetallicRoughness":{"roughnessFactor":0.5,
                     "metallicRoughnessTexture":{"index":0}}})",
                      R"("textures":[{"source":0}],"images":[{"uri":"rough.png"}],)"));
    EXPECT_EQ(use.roughness, (Range{0, 0.5, Origin::texture}));
    ASSERT_EQ(use.notes.size(), 2u);
    EXPECT_NE(use.notes[0].find("\"rough.png\""), std::string::npos);
}

const char* const kTwoScenes = R"({"asset":{"version":"2.0"},"scene":1,
    "scenes":[{"name":"left","nodes":[0]},{"name":"right","nodes":[1]}],
    "nodes":[{"mesh":0},{"children":[2]},{"mesh":1},{"mesh":2}],
    "meshes":[{"primitives":[{"material":0}]},
              {"primitives":[{"material":1},{},{"material":1,"attributes":{"COLOR_0":0}}]},
              {"primitives":[{"material":2}]}],
    "materials":[{"name":"a"},{"name":"b"},{"name":"c"}]})";

TEST(Gltf, OnlyWhatTheSceneReachesCounts) {
    const SceneUse right = read_scene(kTwoScenes, {});
    ASSERT_EQ(right.materials.size(), 2u);
    EXPECT_EQ(right.materials[0].index, 1u);
    // Colours of vertices are factors from 0 to 1.
    EXPECT_EQ(right.materials[0].metal_f0[0], (Range{0, 1, Origin::texture}));
    EXPECT_EQ(right.materials[1].index, std::nullopt);
    EXPECT_EQ(right.materials[1].name, "default material");
    ASSERT_EQ(right.unused.size(), 2u);
    EXPECT_EQ(right.unused[0].name, "a");
    for (const char* name : {"left", "0"}) {
        const SceneUse left = read_scene(kTwoScenes, {.scene = name, .variant = ""});
        ASSERT_EQ(left.materials.size(), 1u);
        EXPECT_EQ(left.materials[0].name, "a");
        EXPECT_EQ(left.scene, 0u);
    }
    EXPECT_THROW(read_scene(kTwoScenes, {.scene = "middle", .variant = ""}), InvalidScene);
}

TEST(Gltf, WithoutASceneAllMeshesCount) {
    const SceneUse use = read_scene(R"({"asset":{"version":"2.0"},
        "meshes":[{"primitives":[{}]}]})",
                                    {});
    EXPECT_EQ(use.materials.size(), 1u);
    EXPECT_EQ(use.scene, std::nullopt);
    EXPECT_EQ(use.warnings.size(), 1u);
}

TEST(Gltf, AVariantByNameTakesThePlaceOfTheDefault) {
    const std::string text = R"({"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],
        "nodes":[{"mesh":0}],"materials":[{"name":"a"},{"name":"b"},{"name":"c"}],
        "extensions":{"KHR_materials_variants":{"variants":[{},{"name":"blue"}]}},
        "meshes":[{"primitives":[{"material":0,"extensions":{"KHR_materials_variants":{
            "mappings":[{"material":1,"variants":[0]},{"material":2,"variants":[1]}]}}}]}]})";
    EXPECT_EQ(only(text).name, "a");
    EXPECT_EQ(only(text, {.scene = "", .variant = "blue"}).name, "c");
    EXPECT_EQ(read_scene(text, {.scene = "", .variant = "all"}).materials.size(), 3u);
    EXPECT_EQ(read_scene(text, {}).unused.at(0).why, "only a material variant names it");
    EXPECT_THROW(read_scene(text, {.scene = "", .variant = "green"}), InvalidScene);
}

// A glTF of material 0 whose numbers at these pointers are moved by an animation.
std::string animated(const std::string& material, const std::vector<std::string>& pointers) {
    std::string channels;
    for (const std::string& pointer : pointers)
        channels += (channels.empty() ? "" : ",") +
                    (R"({"target":{"path":"pointer","extensions":{"KHR_animation_pointer":{)"
                     R"("pointer":"/materials/0/)" +
                     pointer + R"("}}}})");
    return scene_of(material, R"("animations":[{"channels":[)" + channels + "]}],");
}

TEST(Gltf, WhatAnAnimationMovesIsEveryValueItMayBe) {
    const std::string dielectric = R"({"pbrMetallicRoughness":{"metallicFactor":0,
        "roughnessFactor":0.5},"extensions":{"KHR_materials_sheen":{},
        "KHR_materials_ior":{"ior":1.4},"KHR_materials_specular":{"specularFactor":0.25}}})";
    const MaterialUse still = only(animated(dielectric, {"name"}));
    EXPECT_EQ(still.roughness, (Range{0.5, 0.5}));
    EXPECT_TRUE(still.notes.empty());
    const MaterialUse moved = only(animated(dielectric, {"pbrMetallicRoughness/roughnessFactor"}));
    EXPECT_EQ(moved.roughness, (Range{0, 1, Origin::animation}));
    ASSERT_EQ(moved.notes.size(), 1u);
    EXPECT_NE(moved.notes[0].find("an animation moves it"), std::string::npos);
    EXPECT_EQ(lobes_of(only(animated(dielectric, {"pbrMetallicRoughness/metallicFactor"}))),
              "metal dielectric diffuse");
    const std::string more = "extensions/KHR_materials_";
    EXPECT_EQ(lobes_of(only(animated(dielectric, {more + "sheen/sheenColorFactor"}))),
              "dielectric diffuse sheen");
    const MaterialUse index = only(animated(dielectric, {more + "ior/ior"}));
    EXPECT_EQ(index.f0[0], (Range{0, 0.25, Origin::animation}));
    const MaterialUse tint = only(animated(dielectric, {more + "specular/specularColorFactor"}));
    EXPECT_EQ(tint.f0[2], (Range{0, 0.25, Origin::animation}));
    EXPECT_EQ(tint.f90, (Range{0.25, 0.25}));
    const MaterialUse metal =
        only(animated(R"({"pbrMetallicRoughness":{}})", {"pbrMetallicRoughness/baseColorFactor"}));
    EXPECT_EQ(metal.metal_f0[1], (Range{0, 1, Origin::animation}));
}

// The library by itself takes each of these for absent, drops its owner, or overflows its stack.
TEST(Gltf, WhatTheLibraryWouldPassOverInSilenceCounts) {
    const auto roughness = [](const std::string& primitive, const std::string& material) {
        const SceneUse use = read_scene(R"({"asset":{"version":"2.0"},"materials":[)" + material +
                                            R"(],"meshes":[{"primitives":[)" + primitive + "]}]}",
                                        {});
        EXPECT_EQ(use.materials.size(), 1u);
        return use.materials.at(0).roughness;
    };
    const std::string third = R"({"pbrMetallicRoughness":{"roughnessFactor":0.25}})";
    EXPECT_EQ(roughness(R"({"material":0})", third), (Range{0.25, 0.25}));
    EXPECT_EQ(roughness(R"({"material":0.0,"indices":7,"targets":7})", third), (Range{0.25, 0.25}));
    EXPECT_EQ(extended("ior", R"("ior":1000000)").ior, 1e6);
    EXPECT_EQ(extended("ior", R"("ior":2e0)").ior, 2);
    const std::string deep = std::string(20, '[') + std::string(20, ']');
    EXPECT_EQ(lobes_of(only(scene_of(R"({"extras":)" + deep + "}", R"("extras":)" + deep + ","))),
              "metal");
}

TEST(Gltf, MaterialExtensionsThatAreNotKnownAreWarnedOf) {
    const auto warnings = [](const std::string& lists) {
        return read_scene(scene_of("{}", lists), {}).warnings.size();
    };
    EXPECT_EQ(warnings(R"("extensionsUsed":["KHR_materials_sheen","EXT_weather"],)"), 0u);
    EXPECT_EQ(warnings(R"("extensionsUsed":["XYZ_materials_fur"],)"), 1u);
    EXPECT_EQ(warnings(R"("extensionsUsed":["MSFT_lod"],)"), 1u);
    EXPECT_EQ(warnings(R"("extensionsUsed":["XYZ_materials_fur"],)"
                       R"("extensionsRequired":["XYZ_materials_fur","EXT_weather"],)"),
              2u);
}

std::string with_extras(const std::string& extras) {
    return R"({"pbrMetallicRoughness":{"roughnessFactor":0.3},"extras":)" + extras + "}";
}

TEST(Gltf, MeasuredDataTakesThePlaceOfLobes) {
    const std::string id = test::measurement('a');
    const MaterialUse use = only(scene_of(with_extras(R"({"kiln_measured":")" + id + "\"}")));
    EXPECT_EQ(use.measured, id);
    EXPECT_EQ(lobes_of(use), "");
    EXPECT_FALSE(use.unlit);
    const SceneUse scene =
        read_scene(scene_of("{}," + with_extras(R"({"kiln_measured":")" + id + "\"}")), {});
    ASSERT_EQ(scene.unused.size(), 1u);
    EXPECT_EQ(scene.unused[0].measured, id);
}

TEST(Gltf, OtherExtrasAreNobodysFault) {
    for (const char* extras : {"7", "[1]", "null", R"("kiln_measured")", R"({"kiln":{}})"})
        EXPECT_EQ(lobes_of(only(scene_of(with_extras(extras)))), "metal") << extras;
    for (const char* wrong : {"7", "{}", R"("felt.csv")", R"("sha256:AB")"}) try {
            read_scene(scene_of(with_extras(R"({"kiln_measured":)" + std::string(wrong) + "}")),
                       {});
            ADD_FAILURE() << wrong;
        } catch (const InvalidScene& error) {
            EXPECT_EQ(error.problems.at(0).pointer, "/materials/0/extras/kiln_measured");
        }
}

TEST(Gltf, NamesAreCutBetweenCharacters) {
    std::string name(255, 'n');
    const MaterialUse use = only(scene_of("{\"name\":\"" + name + "\u00e4\u00e4\"}"));
    EXPECT_EQ(use.name, name);
}

}  // namespace
}  // namespace kiln
