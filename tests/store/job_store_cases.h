// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>
#include <ostream>
#include <string>

#include "server/store/job_store.h"
#include "tests/store/support.h"

namespace kiln::test {

using std::chrono::hours;
using std::chrono::milliseconds;

/// One implementation of JobStore. Whoever writes another adds a row to kJobStoreCases and has the
/// whole suite.
struct JobStoreCase {
    const char* name;
    std::unique_ptr<JobStore> (*open)(const TemporaryFolder& folder);
};

inline void PrintTo(const JobStoreCase& one, std::ostream* out) { *out << one.name; }

inline const JobStoreCase kJobStoreCases[] = {
    {"sqlite",
     [](const TemporaryFolder& folder) { return open_sqlite_job_store(folder / "jobs.db"); }},
};

class JobStoreTest : public testing::TestWithParam<JobStoreCase> {
  protected:
    std::unique_ptr<JobStore> open() { return GetParam().open(folder_); }
    JobRecord must_claim(const std::string& worker, milliseconds lease = hours(1)) {
        auto job = store_->claim(worker, lease, kAttemptsMax);
        if (!job) throw std::runtime_error("nothing to claim");
        return *job;
    }
    JobRecord must_get(const std::string& id) { return store_->get(id).value(); }

    static constexpr int kAttemptsMax = 3;
    static constexpr milliseconds kRunOut{0};  ///< a lease that is over when it begins
    TemporaryFolder folder_;
    std::unique_ptr<JobStore> store_ = open();
};

inline std::string case_name(const testing::TestParamInfo<JobStoreCase>& info) {
    return info.param.name;
}

}  // namespace kiln::test
