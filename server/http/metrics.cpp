// SPDX-License-Identifier: Apache-2.0
#include "server/http/metrics.h"

#include <array>
#include <cstdio>
#include <string_view>

namespace kiln {

namespace {

void head(std::string& text, std::string_view name, std::string_view type, std::string_view help) {
    text += "# HELP " + std::string(name) + ' ' + std::string(help) + "\n# TYPE " +
            std::string(name) + ' ' + std::string(type) + '\n';
}

void single(std::string& text, std::string_view name, std::string_view type, std::string_view help,
            std::uint64_t value) {
    head(text, name, type, help);
    text += std::string(name) + ' ' + std::to_string(value) + '\n';
}

void jobs(std::string& text, const JobCounts& counts) {
    head(text, "kiln_jobs", "gauge", "Jobs in the store by state.");
    const std::array rows{
        std::pair{JobState::queued, counts.queued}, std::pair{JobState::running, counts.running},
        std::pair{JobState::done, counts.done}, std::pair{JobState::failed, counts.failed},
        std::pair{JobState::cancelled, counts.cancelled}};
    for (const auto& [state, count] : rows)
        text += "kiln_jobs{state=\"" + std::string(to_word(state)) + "\"} " +
                std::to_string(count) + '\n';
    head(text, "kiln_queue_oldest_seconds", "gauge", "Age of the oldest queued job.");
    std::array<char, 64> line{};
    std::snprintf(line.data(), line.size(), "kiln_queue_oldest_seconds %.3f\n",
                  static_cast<double>(counts.oldest_queued_ms) / 1000);
    text += line.data();
}

}  // namespace

std::string metrics_text(const Metrics& metrics, const Gauges& gauges) {
    std::string text;
    head(text, "kiln_http_requests_total", "counter", "Answers by status.");
    for (std::size_t status = 0; status < metrics.answers.size(); ++status)
        if (const std::uint64_t count = metrics.answers[status]; count != 0)
            text += "kiln_http_requests_total{code=\"" + std::to_string(status) + "\"} " +
                    std::to_string(count) + '\n';
    if (gauges.jobs) jobs(text, *gauges.jobs);
    single(text, "kiln_cache_hits_total", "counter", "Posted jobs whose result was at hand.",
           metrics.cache_hits);
    single(text, "kiln_cache_misses_total", "counter", "Posted jobs that were queued.",
           metrics.cache_misses);
    single(text, "kiln_jobs_joined_total", "counter", "Posted jobs that were queued or running.",
           metrics.joined);
    single(text, "kiln_jobs_refused_total", "counter", "Posted jobs refused by the full queue.",
           metrics.refused);
    single(text, "kiln_worker_restarts_total", "counter", "Workers started again after a death.",
           metrics.worker_restarts);
    single(text, "kiln_workers", "gauge", "Workers alive.", gauges.workers_alive);
    single(text, "kiln_http_connections", "gauge", "Open connections.", gauges.connections);
    single(text, "kiln_http_waiting", "gauge", "Long-polls and event streams.", gauges.waiting);
    return text;
}

}  // namespace kiln
