// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "client/commands.h"
#include "client/interrupt.h"
#include "client/measurements.h"
#include "server/spec/job_spec.h"

namespace kiln::client {

/// What came of a job.
struct Baking {
    std::string image;
    std::string report;   ///< JSON
    std::string sidecar;  ///< JSON of measured kinds, else ""
    std::string where;    ///< the server, or "" for this process
    bool cached = false;
};

/// On the server that was named, else on one at the usual place, else in this process. Throws
/// Failure, or what the engine throws; leaves through `stop` where it was asked to.
/// `files` are what measured kinds are made of; a server that lacks one gets it.
Baking run_job(const RunOptions& options, const JobSpec& job, const Stop& stop,
               const MeasurementFiles& files = {});

}  // namespace kiln::client
