// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <string>

#include "server/compute/report.h"
#include "server/spec/job_spec.h"

namespace kiln::client {

struct Written {
    std::string output;
    std::string size;  ///< of the image in texels, "" where the job's resolution says it
    std::size_t byte_count = 0;
    std::string where;    ///< the server, "" for this process
    bool cached = false;  ///< nothing was computed
    bool brief = false;   ///< a program reads: warnings only
};

/// A report for people, on standard error.
void summarise(const Report& report, const JobSpec& job, const Written& written);

}  // namespace kiln::client
