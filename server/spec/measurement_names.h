// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace kiln {

/// The 64 hex digits of an id, "" where it is none.
std::string measurement_digest(std::string_view id);

/// What stands in the place of one that is none must be: a sentence's end.
inline constexpr const char* kMeasurementAllowed =
    "\"sha256:\" and 64 lower-case hex digits, as POST /v1/measurements answers";

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
