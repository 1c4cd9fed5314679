// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace kiln {

/// Asks PoCL to keep each of its threads on a core of its own, where this process may use every
/// core; a POCL_AFFINITY that is set stays. Without it the scheduler often wakes them all on one
/// core, and a launch takes as long as on one thread. Sets the environment: call it before any
/// thread starts and before the first OpenCL call.
void pin_opencl_threads();

}  // namespace kiln
