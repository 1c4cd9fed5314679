// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "server/base/bound.h"
#include "server/settings/settings.h"
#include "server/store/blob_store.h"
#include "server/store/job_store.h"
#include "server/store/measurement_store.h"

namespace kiln {

/// What results come from: ServiceParts::engine and ::readers.
struct Identity {
    std::string engine;
    std::int64_t readers = 0;
};

/// Serves until SIGTERM or SIGINT, which the caller must have blocked in all threads; the first one
/// lets running jobs end within drain_s, a second one drops them into the queue. `bounds`
/// are those of ServiceParts. Returns the exit status. Throws Error("cannot_listen" |
/// "store_failed" | "bad_setting").
int serve(const Settings& settings, const Identity& identity, const Bounds& bounds, JobStore& jobs,
          BlobStore& blobs, MeasurementStore& measurements);

}  // namespace kiln
