// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace kiln {

/// Where a job's text names its measurements: a JSON pointer for each, in their order. The text has
/// passed parse_job.
std::vector<std::string> measurement_pointers(std::string_view job_text);

/// The job's text with each text that names a measurement given to `resolve`, which returns what is
/// to stand there. Text that is no JSON object with such names comes back as it is.
std::string with_measurements(std::string_view job_text,
                              const std::function<std::string(const std::string&)>& resolve);

/// Adds the digests that a canonical job names. A material's name may look like one; that only adds
/// a digest too many.
void named_measurements(std::string_view canonical_job, std::set<std::string>& digests);

}  // namespace kiln
