// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>
#include <cstddef>
#include <cstdint>

#include "server/base/bound.h"

namespace kiln {

/// Finished jobs kept by default: at a few kB each, some hundred MB at most.
inline constexpr std::int64_t kFinishedJobsMax = 100'000;
/// Damaged blobs kept to look into what went wrong; the oldest go first.
inline constexpr std::size_t kQuarantineFilesMax = 16;

/// Measurements that are kept, beside the budget of their bytes: many small ones would be a long
/// index.
inline constexpr std::int64_t kMeasurementsMax = 20'000;

/// Wait for the lock of the job store. Covers the longest write of another process with room to
/// spare; longer means that it hangs.
inline constexpr std::chrono::milliseconds kBusyTimeMax{5000};

Bounds store_bounds();

}  // namespace kiln
