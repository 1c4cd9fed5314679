// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "client/commands.h"
#include "client/interrupt.h"
#include "server/spec/job_spec.h"

namespace kiln::client {

/// What came of a job.
struct Baking {
    std::string image;
    std::string report;  ///< JSON
    std::string where;   ///< the server, or "" for this process
    bool cached = false;
};

/// Where jobs are baked: a server, or this process.
class Bakery {
  public:
    virtual ~Bakery() = default;
    /// In the order of the jobs; of several, one request. Throws Failure, or what the engine
    /// throws; leaves through Stop where it was asked to.
    virtual std::vector<Baking> bake(const std::vector<JobSpec>& jobs) = 0;
    /// What makes the images: kernel digest "/" encoder revision.
    virtual std::string engine() = 0;
    virtual std::string where() const = 0;  ///< the server's URL, "" for this process
};

/// The server that was named, one at the usual place, or else this process, which is then said.
/// `stop` outlives it. `opencl_wait`: for OpenCL's program, in this process.
std::unique_ptr<Bakery> open_bakery(const RunOptions& options, const Stop& stop,
                                    std::chrono::milliseconds opencl_wait);

/// One job, with patience for OpenCL. A server that nobody asked for and that fails does not fail
/// the bake: it goes on in this process.
Baking run_job(const RunOptions& options, const JobSpec& job, const Stop& stop);

}  // namespace kiln::client
