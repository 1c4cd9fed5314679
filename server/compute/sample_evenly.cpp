// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "server/base/error.h"
#include "server/compute/non_finite.h"
#include "server/compute/sampling.h"
#include "server/compute/trust.h"

namespace kiln {

namespace {

using Clock = std::chrono::steady_clock;

/// The first level of a trace: the spread of fewer replicates says little, and each level costs a
/// call.
constexpr std::uint32_t kTraceReplicates = 4;

/// Places whose estimates one task stores.
constexpr std::size_t kPlacesATask = 512;

/// Replicates one after the other, block by block.
class Even {
  public:
    explicit Even(const Sampling& sampling) : s_(sampling) {
        for (const Pass& pass : s_.plan.passes) planned_ += pass.places.count();
        planned_ *= static_cast<std::uint64_t>(s_.job.sample_count);
    }

    void run() {
        for (const Pass& pass : s_.plan.passes)
            for (const Region& region : regions_of(pass, s_.job.sample_count, s_.pool)) {
                if (s_.job.precision == Precision::float64)
                    run_region<double>(pass, region);
                else
                    run_region<float>(pass, region);
            }
    }

  private:
    const PointSet& points(PointKind kind) {
        const auto at = points_.find(kind);
        if (at != points_.end()) return at->second;
        return points_
            .emplace(kind, make_points(s_.job.sampler, kind, s_.job.seed, s_.job.sample_count))
            .first->second;
    }

    template <typename Scalar>
    void run_region(const Pass& pass, const Region& region) {
        Launches<Scalar> launches(s_.backend, s_.pool, pass, region);
        for (std::size_t d = 0; d < region.draws.size(); ++d)
            launches.set_points(d, points(region.draws[d].points));
        const PointSet& set = points(region.draws[0].points);  // as to batches all are alike
        s_.account.replicates = static_cast<std::int64_t>(set.replicate_sizes.size());
        const Means means(pass.shares, region);
        Replicates replicates(means.list());
        const std::size_t block = s_.backend.block_places() / cost_of(region);
        for (std::size_t first = 0; first < region.places.size(); first += block) {
            const auto places = std::span(region.places)
                                    .subspan(first, std::min(block, region.places.size() - first));
            launches.set_places(places);
            replicates.reset(means.facts(pass, region, s_.pool, places));
            run_block(set, region, launches, replicates);
            store(pass, means, replicates, places);
            for (const Draw& draw : region.draws)
                s_.account.count_work(draw.what, places.size() * set.samples());
        }
    }

    template <typename Scalar>
    void run_block(const PointSet& set, const Region& region, Launches<Scalar>& launches,
                   Replicates& replicates) {
        const std::size_t cost = cost_of(region);
        auto started = Clock::now();
        double elapsed = 0;
        std::vector<TraceLevel> trace;
        for (std::size_t first = 0; first < set.batches.size();) {
            const std::size_t count = launch_batches(set, first, launches.stride() * cost);
            replicates.add(s_.pool, set, first, count,
                           launches.run(std::span(set.batches).subspan(first, count)));
            std::uint64_t samples = 0;
            for (std::size_t b = first; b < first + count; ++b)
                samples += set.batches[b].point_count;
            first += count;
            elapsed += seconds_since(started);
            std::optional<double> error_max;
            if (is_trace_level(set, replicates, first)) {
                trace.push_back({replicates.samples(), elapsed, summary(replicates)});
                if (set.replicate_sizes.size() > 1) error_max = trace.back().error.max;
            }
            done_ += samples * replicates.place_count();
            s_.account.report_progress(static_cast<double>(done_) / static_cast<double>(planned_),
                                       error_max);
            started = Clock::now();
        }
        if (const std::uint64_t bad = replicates.non_finite(); bad != 0)
            throw non_finite(
                "of the values of the table " + std::to_string(bad) + (bad == 1 ? " is" : " are"),
                region.draws[0].what.material.distribution);
        s_.account.add_trace(std::move(trace));
        s_.account.count_samples(replicates.place_count() * set.samples(), set.samples());
        s_.account.integrate_s += elapsed;
    }

    /// Batches of the next call: bounded work, and none past the next level of the trace.
    std::size_t launch_batches(const PointSet& set, std::size_t first, std::size_t stride) const {
        const std::uint32_t replicate = set.replicate_of_batch[first];
        std::uint32_t level = kTraceReplicates;
        while (level <= replicate) level *= 2;
        std::size_t count = 0;
        std::uint64_t samples = 0;
        for (std::size_t b = first; b < set.batches.size() && set.replicate_of_batch[b] < level;
             ++b, ++count) {
            samples += set.batches[b].point_count * stride;
            if (count > 0 && samples > launch_samples(s_.backend)) break;
        }
        return count;
    }

    /// Levels of the trace are powers of two of complete replicates, and the last.
    static bool is_trace_level(const PointSet& set, const Replicates& replicates,
                               std::size_t batches_done) {
        const std::size_t n = replicates.completed();
        const bool half_done = set.replicate_of_batch[batches_done - 1] == n;
        return !half_done &&
               (n == set.replicate_sizes.size() || (n >= kTraceReplicates && (n & (n - 1)) == 0));
    }

    ErrorSummary summary(const Replicates& replicates) const {
        ErrorSummary whole;
        for (std::size_t m = 0; m < replicates.mean_count(); ++m)
            whole.add(replicates.summary(s_.pool, m));
        return whole;
    }

    void store(const Pass& pass, const Means& means, const Replicates& replicates,
               std::span<const std::uint32_t> places) {
        const std::size_t tasks = (places.size() + kPlacesATask - 1) / kPlacesATask;
        std::vector<Account::Stored> stored(tasks, Account::Stored(pass));
        s_.pool.parallel_for(tasks, [&](std::size_t task) {
            const std::size_t begin = task * kPlacesATask;
            store_some(pass, means, replicates, begin,
                       places.subspan(begin, std::min(kPlacesATask, places.size() - begin)),
                       stored[task]);
        });
        for (const Account::Stored& some : stored) s_.account.add(pass, some);
    }

    /// Of places [begin, begin + places.size()) of the block.
    void store_some(const Pass& pass, const Means& means, const Replicates& replicates,
                    std::size_t begin, std::span<const std::uint32_t> places,
                    Account::Stored& stored) const {
        const std::size_t count = places.size();
        std::vector<Estimate> of(replicates.mean_count() * count);
        for (std::size_t m = 0; m < replicates.mean_count(); ++m)
            replicates.estimates(m, begin, std::span(of).subspan(m * count, count));
        for (std::size_t i = 0; i < count; ++i) {
            bool suspect = replicates.completed() > 1 &&
                           samples_miss_peak(pass, places[i], replicates.samples());
            for (std::size_t s = 0; s < pass.shares.size(); ++s) {
                const Share& share = pass.shares[s];
                const Estimate estimate = means.estimate(
                    share, s, places[i], [&](std::size_t m) { return of[m * count + i]; });
                s_.account.store(pass, s, places[i], estimate, stored);
                suspect |= replicates.completed() > 1 &&
                           misses_mirror_limit(pass, share, places[i], estimate,
                                               error_bound(estimate, s_.job.precision));
            }
            if (suspect) stored.suspected.add(pass, places[i]);
        }
    }

    const Sampling& s_;
    std::map<PointKind, PointSet> points_;  // slices and averages share them
    std::uint64_t planned_ = 0, done_ = 0;
};

}  // namespace

void sample_evenly(const Sampling& sampling) { Even(sampling).run(); }

}  // namespace kiln
