// SPDX-License-Identifier: Apache-2.0
// libFuzzer's entry to the reader of scenes and the planner; see CONTRIBUTING.md.
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "server/scene/scene_plan.h"
#include "server/spec/contract.h"

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
