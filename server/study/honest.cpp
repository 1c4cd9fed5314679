// SPDX-License-Identifier: Apache-2.0
#include "server/study/honest.h"

#include <cmath>
#include <cstdio>
#include <map>
#include <string>

#include "server/compute/estimate.h"

namespace kiln {

namespace {

constexpr double kMissed = 0.08;
/// Of a study of honest reports that says they are not.
constexpr double kLevel = 1e-4;

struct Group {
    std::size_t count = 0;
    double missed = 0;
    void add(const JudgedRun& run) { ++count, missed += run.missed; }
    double mean() const { return missed / static_cast<double>(count); }
};

}  // namespace

JudgedRun judged_run(const JobSpec& job, const Outcome& outcome, const Table& truth, double times) {
    std::size_t missed = 0, count = 0;
    for (std::size_t c = 0; c < truth.planes.size(); ++c)
        for (std::size_t i = 0; i < truth.planes[c].size(); ++i, ++count) {
            const double off =
                std::abs(static_cast<double>(outcome.table.planes[c][i]) - truth.planes[c][i]);
            const double bound = kStudentT * times * outcome.standard_errors[c][i];
            missed += !(off <= bound + rounding_floor(job.precision));
        }
    return {job.importance, static_cast<double>(missed) / static_cast<double>(count),
            outcome.report.status == "rare_event_suspected"};
}

double most_missed(std::size_t runs, double level) {
    const double needed = -std::log(level) / static_cast<double>(runs);
    const auto entropy = [](double q) {
        return q * std::log(q / kMissed) + (1 - q) * std::log((1 - q) / (1 - kMissed));
    };
    double low = kMissed, high = 1;
    for (int i = 0; i < 60; ++i) {
        const double middle = 0.5 * (low + high);
        (entropy(middle) < needed ? low : high) = middle;
    }
    return high;
}

Verdict honest_errors(const std::vector<JudgedRun>& runs) {
    std::map<std::string, Group> groups;
    std::size_t judged = 0;
    for (const JudgedRun& run : runs) {
        if (run.suspected) continue;
        const bool blind =
            run.importance == Importance::cosine || run.importance == Importance::uniform;
        groups[blind ? "cosine and uniform" : "vndf and ndf"].add(run);
        ++judged;
    }
    const double level = kLevel / static_cast<double>(groups.size());
    double worst = 0, most = 1, beyond = -1;
    std::string where = "none";
    for (const auto& [name, group] : groups) {
        const double limit = most_missed(group.count, level);
        if (group.mean() - limit <= beyond) continue;
        beyond = group.mean() - limit, worst = group.mean(), most = limit, where = name;
    }
    char words[256];
    std::snprintf(
        words, sizeof words,
        "%.1f %% of the values lie outside their 95 %% intervals (%s), chance leaves %.1f "
        "%%; judged are %zu of %zu runs, the others say themselves that they missed rare "
        "events",
        100 * worst, where.c_str(), 100 * most, judged, runs.size());
    return {"reported errors are honest", worst <= most, true, worst, most, words};
}

}  // namespace kiln
