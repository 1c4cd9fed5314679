// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <string>

namespace kiln {

/// The bounds of the contract that stand beside its schemas (x-kiln-limits of api/openapi.json,
/// which also has their units and meaning).
struct Limits {
    std::int64_t job_bytes_max = 0;
    std::int64_t depth_max = 0;
    std::int64_t problems_max = 0;
    std::int64_t resolution_max = 0;
    std::int64_t sample_count_max = 0;
    std::int64_t work_samples_max = 0;
    std::int64_t png_channels_max = 0;
    std::int64_t wait_s_max = 0;
    std::int64_t list_limit_max = 0;
    std::int64_t list_limit_default = 0;
    std::int64_t batch_jobs_max = 0;
    std::int64_t batch_bytes_max = 0;
    std::int64_t scene_bytes_max = 0;
    std::int64_t scene_entries_max = 0;
    std::int64_t gltf_materials_max = 0;
    std::int64_t atlas_materials_max = 0;
    std::int64_t slice_count_max = 0;
    std::int64_t gutter_max = 0;
    std::int64_t atlas_side_max = 0;
    std::int64_t atlas_texels_max = 0;
    std::int64_t view_side_min = 0;
    std::int64_t view_side_max = 0;
    std::int64_t sampling_side_max = 0;
};

/// Read once from the embedded contract. Throws Error("contract") when the contract contradicts
/// itself.
const Limits& limits();

/// The same as JSON text, {name: {value, unit, description}}, for /v1/capabilities.
std::string limits_json();

}  // namespace kiln
