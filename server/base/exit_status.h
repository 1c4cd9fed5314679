// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace kiln {

/// Exit status of a worker whose watchdog saw no progress: its device hangs.
inline constexpr int kExitHung = 86;

}  // namespace kiln
