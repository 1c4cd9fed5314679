// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>

#include "server/base/bound.h"

namespace kiln {

/// The largest image (16 Mi texels, four channels) takes well under a minute to encode and store.
inline constexpr std::chrono::minutes kStoringTimeMax{10};

/// A step of a measured material that tells no progress: reading its file, integrating its albedos.
inline constexpr std::chrono::minutes kQuietStepMax{2};

/// Of the worker and of the engine in it.
Bounds worker_bounds();

}  // namespace kiln
