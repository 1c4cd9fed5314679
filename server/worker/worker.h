// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "server/settings/settings.h"
#include "server/store/blob_store.h"
#include "server/store/job_store.h"

namespace kiln {

/// Claims jobs from the store and bakes them until it is told to end (SIGTERM, SIGINT, or the
/// supervisor's end), which the caller must have blocked in all threads. Returns the exit status.
int run_worker(const Settings& settings, JobStore& jobs, BlobStore& blobs);

}  // namespace kiln
