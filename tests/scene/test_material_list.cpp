// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "server/scene/scene.h"
#include "server/spec/contract.h"

namespace kiln {
namespace {

TEST(MaterialList, TheContractsExampleIsRead) {
    const auto& example = contract()["components"]["schemas"]["Scene"]["examples"][0];
    const SceneUse scene = read_scene(example.dump(), {});
    EXPECT_EQ(scene.format, "materials");
    ASSERT_EQ(scene.materials.size(), 2u);
    EXPECT_EQ(scene.materials[0].name, "steel");
    EXPECT_EQ(scene.materials[0].roughness, (Range{0.4, 0.4}));
    EXPECT_EQ(scene.materials[0].metal_f0[2], (Range{0.58, 0.58}));
    EXPECT_EQ(scene.materials[1].roughness, (Range{0.4, 0.7}));
    EXPECT_EQ(scene.materials[1].clearcoat_roughness, (Range{0.05, 0.05}));
    EXPECT_NEAR(scene.materials[1].f0[0].lo, 0.04, 1e-15);
    ASSERT_EQ(scene.unused.size(), 1u);
    EXPECT_EQ(scene.unused[0].index, 2u);
}

TEST(MaterialList, WhatIsNotGivenMayBeAnything) {
    const SceneUse scene = read_scene(R"({"materials":[{"lobes":["metal","sheen"]},{}]})", {});
    ASSERT_EQ(scene.materials.size(), 2u);
    EXPECT_EQ(scene.materials[0].roughness, (Range{0, 1, Origin::texture}));
    EXPECT_EQ(scene.materials[0].sheen_roughness, (Range{0, 1, Origin::texture}));
    EXPECT_EQ(scene.materials[0].metal_f0[0], (Range{0, 1, Origin::texture}));
    EXPECT_EQ(scene.materials[0].notes.size(), 2u);
    EXPECT_TRUE(scene.materials[1].unlit);
}

TEST(MaterialList, HasNoScenesToChooseFrom) {
    EXPECT_THROW(read_scene(R"({"materials":[{}]})", {.scene = "1", .variant = ""}), InvalidScene);
    EXPECT_THROW(read_scene(R"({"materials":[{}]})", {.scene = "", .variant = "red"}),
                 InvalidScene);
}

}  // namespace
}  // namespace kiln
