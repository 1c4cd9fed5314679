// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <string_view>
#include <vector>

namespace kiln {

/// The job texts of a batch document (schema Batch, at most limits().batch_bytes_max), each for
/// parse_job. Throws Malformed, or InvalidJob when the batch itself breaks the schema; the jobs are
/// not judged here.
std::vector<std::string> batch_jobs(std::string_view text);

}  // namespace kiln
