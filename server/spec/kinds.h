// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string_view>

#include "server/spec/job_spec.h"

namespace kiln {

/// True where a job of this kind reads the top-level field; one that it does not read is refused.
bool is_read(Kind kind, std::string_view field);

/// Of measured reflectance: its jobs name measurements and have a side-car.
bool is_measured(Kind kind);
/// Slices about the mirror direction: slices and atlas.
bool is_sliced(Kind kind);
/// Pictures for people: a PNG of sRGB codes.
bool is_view(Kind kind);
/// True where a job of this kind reads the field of `measured`.
bool is_read_of_measured(Kind kind, std::string_view field);

/// What a study sets itself: quantities, axes, resolution and picture format.
void prepare_study(JobSpec& job);

/// Of a furnace study's table: centres along NoV, nodes from roughness 0.1 to 1.
inline constexpr std::int64_t kFurnaceAngles = 64, kFurnaceRoughnesses = 10;

}  // namespace kiln
