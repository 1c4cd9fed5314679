// SPDX-License-Identifier: Apache-2.0
#include "server/compute/integrate.h"

#include "server/compute/sampling.h"

namespace kiln {

Outcome integrate(const JobSpec& job, const Plan& plan, Backend& backend, ThreadPool& pool,
                  const Control& control, bool standard_error_planes) {
    const auto start = std::chrono::steady_clock::now();
    Account account(job, plan, control, standard_error_planes);
    const Sampling sampling{job, plan, backend, pool, account};
    if (job.target_error || job.time_budget_s)
        sample_adaptively(sampling);
    else
        sample_evenly(sampling);
    Outcome outcome = account.finish();
    RunTime& time = outcome.report.run_time_s;
    time.assemble = seconds_since(start) - time.integrate;
    return outcome;
}

}  // namespace kiln
