// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <set>

#include "server/scene/scene_plan.h"
#include "server/spec/contract.h"
#include "tests/scene/scenes.h"

namespace kiln {
namespace {

using test::HostileScene;

struct Refused {
    std::string code, detail;
    std::vector<Problem> problems;
};

/// What reading and planning a scene ends in; anything but these errors is a failure.
Refused try_scene(const std::string& bytes) {
    try {
        const ScenePlan plan = plan_scene(read_scene(bytes, {}), {});
        const std::string document = to_json(plan);
        EXPECT_TRUE(contract_problems("Plan", document).empty());
        return {};
    } catch (const Malformed& error) {
        return {error.code(), error.what(), error.problems};
    } catch (const InvalidScene& error) {
        return {error.code(), error.what(), error.problems};
    }
}

TEST(Hostile, EachIsRefusedByNameOrReadForWhatItIs) {
    const auto scenes = test::hostile_scenes();
    EXPECT_GE(scenes.size(), 100u);
    std::set<std::string> names;
    for (const HostileScene& scene : scenes) {
        SCOPED_TRACE(scene.name);
        EXPECT_TRUE(names.insert(scene.name).second);
        const Refused refused = try_scene(scene.bytes);
        EXPECT_EQ(refused.code, scene.code) << refused.detail;
        if (scene.code.empty()) continue;
        ASSERT_FALSE(refused.problems.empty());
        EXPECT_TRUE(std::any_of(refused.problems.begin(), refused.problems.end(),
                                [&](const Problem& p) { return p.pointer == scene.pointer; }))
            << refused.problems[0].pointer << ": " << refused.problems[0].message;
        EXPECT_FALSE(refused.problems[0].message.empty());
        EXPECT_LT(refused.detail.size(), 600u);
    }
}

TEST(Hostile, AnImageThatCannotBeReadStandsForEveryValueAndIsNoted) {
    for (const HostileScene& scene : test::hostile_scenes()) {
        if (!scene.code.empty()) continue;
        SCOPED_TRACE(scene.name);
        const SceneUse use = read_scene(scene.bytes, {});
        ASSERT_EQ(use.materials.size(), 1u);
        EXPECT_EQ(use.materials[0].roughness, (Range{0, 1, Origin::texture}));
        EXPECT_EQ(use.materials[0].metallic, (Range{0, 1, Origin::texture}));
        EXPECT_EQ(use.materials[0].notes.size(), 2u);
    }
}

// KILN_FUZZ_ROUNDS=1000000 is the long form; every round is a function of its number alone.
TEST(Hostile, DamagedScenesAreReadOrRefused) {
    const char* given = std::getenv("KILN_FUZZ_ROUNDS");
    const std::uint64_t rounds = given != nullptr ? std::strtoull(given, nullptr, 10) : 4000;
    std::uint64_t read = 0, refused = 0;
    const auto scenes = test::sound_scenes();
    for (std::uint64_t round = 0; round < rounds; ++round) {
        const std::string bytes = test::mutated(scenes[round % scenes.size()], round);
        SCOPED_TRACE(round);
        ++(try_scene(bytes).code.empty() ? read : refused);
        if (HasFailure()) return;
    }
    // Damage that is always fatal, or never, reaches nothing.
    EXPECT_GT(read, rounds / 20);
    EXPECT_GT(refused, rounds / 20);
}

}  // namespace
}  // namespace kiln
