// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <atomic>
#include <cstdint>
#include <optional>
#include <string>

#include "server/store/job_store.h"

namespace kiln {

/// Counters of one front process since its start.
struct Metrics {
    std::array<std::atomic<std::uint64_t>, 600> answers{};  ///< by status
    std::atomic<std::uint64_t> cache_hits{0};    ///< posts answered from a finished result
    std::atomic<std::uint64_t> cache_misses{0};  ///< posts that queued a job
    std::atomic<std::uint64_t> joined{0};        ///< posts of a job already queued or running
    std::atomic<std::uint64_t> refused{0};       ///< posts refused by the full queue
    std::atomic<std::uint64_t> worker_restarts{0};
};

struct Gauges {
    std::optional<JobCounts> jobs;  ///< empty when the store fails
    std::size_t connections = 0;
    std::size_t waiting = 0;  ///< long-polls and event streams
    std::size_t workers_alive = 0;
};

/// Prometheus text format 0.0.4.
std::string metrics_text(const Metrics& metrics, const Gauges& gauges);

}  // namespace kiln
