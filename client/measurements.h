// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <map>
#include <string>
#include <vector>

#include "client/api.h"
#include "server/spec/job_spec.h"

namespace kiln::client {

/// The files at hand that a job's measurements may be, by SHA-256 (64 hex digits).
class MeasurementFiles {
  public:
    /// Throws Failure(usage) for a file that cannot be read or is too large. Returns the SHA-256.
    std::string add(const std::string& path);
    bool has(const std::string& digest) const { return paths_.contains(digest); }
    /// Throws Failure(usage) where there is no such file, or it changed since it was added.
    std::string bytes(const std::string& digest) const;

  private:
    std::map<std::string, std::string> paths_;
};

/// `job_text` with the names of files in it, relative to the folder of `job_path`, replaced by the
/// measurements that they are; they and `more` are added to `files`. Throws Failure(usage) for a
/// file of `more` that the job does not name.
std::string take_measurements(const std::string& job_text, const std::string& job_path,
                              const std::vector<std::string>& more, MeasurementFiles& files);

/// Gives the server what a job names, is at hand, and is not there yet.
void upload_missing(Api& api, const JobSpec& job, const MeasurementFiles& files);

}  // namespace kiln::client
