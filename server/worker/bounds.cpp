// SPDX-License-Identifier: Apache-2.0
#include "server/worker/bounds.h"

#include "server/compute/opencl_programs.h"
#include "server/compute/points.h"

namespace kiln {

Bounds worker_bounds() {
    return {
        {"storing_min_max", static_cast<std::uint64_t>(kStoringTimeMax.count()), "min",
         "For a result to be encoded and stored."},
        {"quiet_step_min_max", static_cast<std::uint64_t>(kQuietStepMax.count()), "min",
         "For a measured file to be read, or its albedos to be integrated."},
        {"device_failures_max", kDeviceFailuresMax, "failures",
         "Of an OpenCL device, before a worker opens it no more."},
        {"replicates_max", kReplicatesMax, "replicates",
         "Independently randomised point sets of a job, from which its standard error comes."},
        {"batch_points_max", kBatchPointsMax, "points", "Summed in working precision at a time."},
    };
}

}  // namespace kiln
