// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <string>

#include "server/compute/report.h"
#include "server/spec/job_spec.h"

namespace kiln::client {

struct Written {
    std::string output;
    std::size_t byte_count = 0;
    std::string where;    ///< the server, "" for this process
    bool cached = false;  ///< nothing was computed
    bool brief = false;   ///< a program reads: warnings only
};

/// In texels, of the image that a job makes; "" of a study, whose picture is as large as it needs.
std::string image_size(const JobSpec& job);

/// A report for people, on standard error.
void summarise(const Report& report, const JobSpec& job, const Written& written);

}  // namespace kiln::client
