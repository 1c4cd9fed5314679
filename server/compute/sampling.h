// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <chrono>
#include <map>

#include "server/compute/account.h"
#include "server/compute/region.h"

namespace kiln {

/// Samples a device call may take: as many as the longest batch of a block. That is milliseconds,
/// so that cancelling, progress and a budget of time are prompt, and the sums that it hands over
/// are still in cache when they are added up.
inline std::uint64_t launch_samples(const Backend& backend) {
    return backend.block_places() * kBatchPointsMax;
}

/// By how much calls and blocks must be smaller where a sample costs more than on the fast path: on
/// the general one some four times, and a walk over facets as much as a hundred. A call of it still
/// takes less than 0.1 s on two cores.
inline std::size_t cost_of(const Region& region) {
    if (region.draws[0].points == PointKind::facet_walk) return 16;
    const auto general = [](const Draw& draw) { return draw.what.material.general != 0; };
    return std::any_of(region.draws.begin(), region.draws.end(), general) ? 4 : 1;
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
