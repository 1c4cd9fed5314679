// SPDX-License-Identifier: Apache-2.0
// libFuzzer's entry to the reader of scenes and the planner; see CONTRIBUTING.md.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "server/scene/scene_plan.h"
#include "server/spec/contract.h"
#include "tests/scene/scenes.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string_view bytes(reinterpret_cast<const char*>(data), size);
    try {
        const kiln::ScenePlan plan = kiln::plan_scene(kiln::read_scene(bytes, {}), {});
        if (!kiln::contract_problems("Plan", kiln::to_json(plan)).empty()) std::abort();
    } catch (const kiln::Malformed&) {
    } catch (const kiln::InvalidScene&) {
    }
    return 0;
}

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t size_max);

/// Damage starts from sound scenes, so that an empty corpus will do.
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t size_max, unsigned seed) {
    static const std::vector<std::string> scenes = kiln::test::sound_scenes();
    const std::string& sound = scenes[seed / 64 % scenes.size()];
    if ((size < 16 || seed % 64 == 0) && sound.size() <= size_max) {
        std::copy(sound.begin(), sound.end(), data);
        size = sound.size();
    }
    return LLVMFuzzerMutate(data, size, size_max);
}
