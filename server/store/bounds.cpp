// SPDX-License-Identifier: Apache-2.0
#include "server/store/bounds.h"

namespace kiln {

Bounds store_bounds() {
    return {
        {"finished_jobs_max", kFinishedJobsMax, "jobs",
         "Finished jobs that are remembered; the first finished are forgotten first."},
        {"quarantine_files_max", kQuarantineFilesMax, "files",
         "Damaged results set aside; the oldest go first."},
        {"measurements_max", kMeasurementsMax, "measurements",
         "Kept; the least recently used go first."},
        {"busy_ms_max", static_cast<std::uint64_t>(kBusyTimeMax.count()), "ms",
         "Wait for the lock of the job store."},
    };
}

}  // namespace kiln
