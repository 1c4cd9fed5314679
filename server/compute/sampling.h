// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>
#include <map>

#include "server/compute/account.h"
#include "server/compute/region.h"

namespace kiln {

/// Samples a device call may take: milliseconds, so that cancelling, progress and a budget of time
/// are prompt, and the sums that it hands over are still in cache when they are added up.
inline constexpr std::uint64_t kLaunchSamples = 1u << 23;

/// What both ways of sampling a job work with.
struct Sampling {
    const JobSpec& job;
    const Plan& plan;
    Backend& backend;
    ThreadPool& pool;
    Account& account;
};

inline double seconds_since(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// Every place of every pass at sample_count samples.
void sample_evenly(const Sampling& sampling);

/// Until target_error, sample_count or time_budget_s is reached: replicates grow by doublings, and
/// places that have converged are left out of the next one.
void sample_adaptively(const Sampling& sampling);

}  // namespace kiln
