// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "client/interrupt.h"
#include "client/terminal.h"
#include "server/compute/report.h"
#include "server/spec/job_spec.h"

namespace kiln::client {

struct BakedJob {
    std::string image;
    std::string report;   ///< JSON
    bool cached = false;  ///< nothing was computed
};

/// Where jobs are baked: a server, or this process.
class Bakery {
  public:
    virtual ~Bakery() = default;
    /// In the order of the jobs. Throws Failure, or what the engine throws.
    virtual std::vector<BakedJob> bake(const std::vector<JobSpec>& jobs) = 0;
    /// What makes the images: kernel digest "/" encoder revision.
    virtual std::string engine() = 0;
    virtual std::string where() const = 0;  ///< the server's URL, "" for this process
};

/// The server that was named, one at the usual place, or else this process, which is then said.
/// `stop` outlives it.
std::unique_ptr<Bakery> open_bakery(const std::string& server, bool local, const Stop& stop,
                                    ProgressMode mode);

}  // namespace kiln::client
