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

/// By how much calls and blocks must be smaller where a sample costs more: a walk takes as long as
/// some hundred samples of a lobe, and a call of it still less than 0.1 s on two cores.
inline std::size_t cost_of(const Region& region) {
    return region.draws[0].points == PointKind::facet_walk ? 16 : 1;
}

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
