// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>
#include <memory>
#include <string>
#include <vector>

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

/// Where jobs are baked: a server, or this process.
class Bakery {
  public:
    virtual ~Bakery() = default;
    /// In the order of the jobs; of several, one request. Throws Failure, or what the engine
    /// throws; leaves through Stop where it was asked to. `files` are what measured kinds are made
    /// of; a server that lacks one gets it.
    virtual std::vector<Baking> bake(const std::vector<JobSpec>& jobs,
                                     const MeasurementFiles& files) = 0;
    virtual Makers makers() = 0;
    /// That it has without being given the file; by SHA-256, 64 hex digits.
    virtual bool has_measurement(const std::string& digest) = 0;
    virtual std::string where() const = 0;  ///< the server's URL, "" for this process
};

/// The server that was named, one at the usual place, or else this process, which is then said.
/// `stop` outlives it. `opencl_wait`: for OpenCL's program, in this process.
std::unique_ptr<Bakery> open_bakery(const RunOptions& options, const Stop& stop,
                                    std::chrono::milliseconds opencl_wait);

/// One job, with patience for OpenCL. A server that nobody asked for and that fails does not fail
/// the bake: it goes on in this process.
Baking run_job(const RunOptions& options, const JobSpec& job, const Stop& stop,
               const MeasurementFiles& files = {});

}  // namespace kiln::client
