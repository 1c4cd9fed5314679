// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "server/base/error.h"
#include "server/compute/non_finite.h"
#include "server/compute/sampling.h"
#include "server/compute/stopping.h"
#include "server/compute/trust.h"

namespace kiln {

namespace {

using Clock = std::chrono::steady_clock;

/// Places that grow together. Their replicates take 128 bytes a mean and place.
constexpr std::size_t kTogether = 1u << 17;

/// Some places of a region on their way through the levels.
template <typename Scalar>
class Group {
  public:
    Group(const Sampling& sampling, const Pass& pass, const Region& region,
          std::span<const std::uint32_t> places, const Deadline& deadline)
        : s_(sampling),
          pass_(pass),
          region_(region),
          places_(places),
          deadline_(deadline),
          means_(pass.shares, region),
          launches_(sampling.backend, sampling.pool, pass, region),
          replicates_(means_.list(), means_.facts(pass, region, sampling.pool, places)),
          rules_(sampling.job),
          progress_(places.size()) {}

    /// report(share of the group's work that is done, error so far) after each launch.
    template <typename ReportProgress>
    void run(ReportProgress report) {
        std::vector<std::uint32_t> active(places_.size());
        std::iota(active.begin(), active.end(), 0u);
        const std::vector<std::int64_t> levels = level_samples(s_.job);
        for (std::size_t level = 0; level < levels.size() && !active.empty() && !out_of_time_;
             ++level) {
            take_points(level == 0 ? 0 : levels[level - 1], levels[level]);
            const auto tell = [&](double part) {
                const double converged =
                    1 - static_cast<double>(active.size()) / static_cast<double>(places_.size());
                const double sampled =
                    (static_cast<double>(level) + part) / static_cast<double>(levels.size());
                report(std::max(converged, sampled), error_max_);
            };
            run_level(level, active, tell);
            add_trace(level, levels[level]);
            std::erase_if(active, [&](std::uint32_t slot) { return progress_[slot].stopped; });
        }
        store(active);
        s_.account.add_trace(std::move(trace_));
        s_.account.integrate_s += elapsed_;
    }

  private:
    void take_points(std::int64_t before, std::int64_t after) {
        for (std::size_t d = 0; d < region_.draws.size(); ++d) {
            set_ = make_more_points(s_.job.sampler, region_.draws[d].points, s_.job.seed, before,
                                    after);
            launches_.set_points(d, set_);
        }
        s_.account.replicates = static_cast<std::int64_t>(set_.replicate_sizes.size());
    }

    template <typename Tell>
    void run_level(std::size_t level, const std::vector<std::uint32_t>& active, Tell tell) {
        const std::size_t block = s_.backend.block_places() / cost_of(region_);
        for (std::size_t first = 0; first < active.size() && !out_of_time_; first += block) {
            const auto slots =
                std::span(active).subspan(first, std::min(block, active.size() - first));
            std::vector<std::uint32_t> places;
            for (const std::uint32_t slot : slots) places.push_back(places_[slot]);
            const auto started = Clock::now();
            launches_.set_places(places);
            replicates_.begin(slots, level == 0 || !is_nested(s_.job.sampler));
            const bool whole = run_batches(level, slots.size(), [&](double part) {
                tell((static_cast<double>(first) + part * static_cast<double>(slots.size())) /
                     static_cast<double>(active.size()));
            });
            if (whole) {
                replicates_.commit(s_.pool, set_);
                for (const std::uint32_t slot : slots) judge(slot);
            }
            elapsed_ += seconds_since(started);
        }
    }

    /// Returns whether all were run. The first level always is: each place needs a value.
    template <typename Tell>
    bool run_batches(std::size_t level, std::size_t places, Tell tell) {
        for (std::size_t first = 0; first < set_.batches.size();) {
            if (level > 0 && deadline_.passed()) {
                out_of_time_ = true;
                return false;
            }
            std::size_t count = 0;
            std::uint64_t points = 0;
            for (std::size_t b = first; b < set_.batches.size(); ++b, ++count) {
                if (count > 0 &&
                    (points + set_.batches[b].point_count) * launches_.stride() * cost_of(region_) >
                        launch_samples(s_.backend))
                    break;
                points += set_.batches[b].point_count;
            }
            replicates_.add(s_.pool, set_, first, count,
                            launches_.run(std::span(set_.batches).subspan(first, count)));
            for (const Draw& draw : region_.draws)
                s_.account.count_work(draw.what, points * places);
            s_.account.count_samples(points * places, 0);
            first += count;
            tell(static_cast<double>(first) / static_cast<double>(set_.batches.size()));
        }
        return true;
    }

    Estimate estimate(std::size_t share, std::size_t slot) const {
        return means_.estimate(pass_.shares[share], share, places_[slot],
                               [&](std::size_t m) { return replicates_.estimate(m, slot); });
    }

    /// Shares of the channel of a share.
    std::size_t shares_beside(std::size_t share) const {
        return s_.account.shares_of(pass_.shares[share].channel);
    }

    /// Whether a place goes on to the next level.
    void judge(std::uint32_t slot) {
        LevelVerdict verdict;
        for (std::size_t s = 0; s < pass_.shares.size(); ++s) {
            const Estimate found = estimate(s, slot);
            if (!std::isfinite(found.value) || !std::isfinite(found.variance))
                throw non_finite("a value of the table is", pass_.what.material.distribution);
            verdict.add(rules_, pass_, pass_.shares[s], shares_beside(s), places_[slot], found);
        }
        progress_[slot].add(verdict, rules_, pass_.places.alpha(places_[slot]),
                            replicates_.samples(slot));
    }

    void add_trace(std::size_t level, std::int64_t samples) {
        if (out_of_time_ && level > 0) return;
        ErrorSummary error;
        for (std::size_t slot = 0; slot < places_.size(); ++slot)
            for (std::size_t s = 0; s < pass_.shares.size(); ++s)
                error.add(estimate(s, slot).variance, 1);
        trace_.push_back({static_cast<std::uint64_t>(samples), elapsed_, error});
        if (set_.replicate_sizes.size() > 1) error_max_ = error.max;
    }

    void store(const std::vector<std::uint32_t>& active) {
        Account& account = s_.account;
        Account::Stored stored(pass_);
        for (std::size_t slot = 0; slot < places_.size(); ++slot) {
            const std::size_t place = places_[slot];
            bool suspect = samples_miss_peak(pass_, place, replicates_.samples(slot));
            for (std::size_t s = 0; s < pass_.shares.size(); ++s) {
                const Share& share = pass_.shares[s];
                const Estimate found = estimate(s, slot);
                account.store(pass_, s, place, found, stored);
                const double bound = error_bound(found, s_.job.precision);
                suspect |= misses_mirror_limit(pass_, share, place, found, bound);
                if (rules_.aims())
                    suspect |= lacks_rare_events(
                        found, std::max(bound, rules_.tolerance(shares_beside(s), found.value)));
            }
            if (suspect && set_.replicate_sizes.size() > 1) stored.suspected.add(pass_, place);
            account.count_samples(0, replicates_.samples(slot));
            const Progressed& state = progress_[slot];
            if (state.stopped && state.at_roundoff) account.at_roundoff.add(pass_, place);
            if (state.stopped && state.at_quantum) account.at_quantum = true;
        }
        account.add(pass_, stored);
        account.out_of_time |= out_of_time_;
        if (!s_.job.target_error) return;
        double now = 0, before = 0;
        for (const std::uint32_t slot : active) {
            const Progressed& state = progress_[slot];
            account.unconverged.add(pass_, places_[slot]);
            account.bound_max = std::max(account.bound_max, state.bound);
            if (state.levels < state.errors.size()) continue;
            now += state.errors[0] * state.errors[0];
            before += state.errors.back() * state.errors.back();
        }
        account.trace_is_flat |= rules_.is_flat(std::sqrt(before), std::sqrt(now));
    }

    const Sampling& s_;
    const Pass& pass_;
    const Region& region_;
    std::span<const std::uint32_t> places_;
    const Deadline& deadline_;
    const Means means_;
    Launches<Scalar> launches_;
    GrowingReplicates replicates_;
    const StoppingRules rules_;
    std::vector<Progressed> progress_;  // [slot]
    PointSet set_;                      // of the level; the last draw's stands for all
    std::vector<TraceLevel> trace_;
    std::optional<double> error_max_;
    double elapsed_ = 0;
    bool out_of_time_ = false;
};

/// All passes, regions and groups, each with its part of the time.
class Adaptive {
  public:
    explicit Adaptive(const Sampling& sampling) : s_(sampling) {
        for (const Pass& pass : s_.plan.passes) planned_ += pass.places.count();
    }

    void run() {
        for (const Pass& pass : s_.plan.passes)
            for (const Region& region : regions_of(pass, s_.job.sample_count, s_.pool))
                for (std::size_t first = 0; first < region.places.size(); first += kTogether) {
                    const auto places =
                        std::span(region.places)
                            .subspan(first, std::min(kTogether, region.places.size() - first));
                    if (s_.job.precision == Precision::float64)
                        run_group<double>(pass, region, places);
                    else
                        run_group<float>(pass, region, places);
                }
    }

  private:
    template <typename Scalar>
    void run_group(const Pass& pass, const Region& region, std::span<const std::uint32_t> places) {
        const double whole = static_cast<double>(planned_),
                     mine = static_cast<double>(places.size());
        const double behind = static_cast<double>(done_);
        // What earlier groups left of their time is there for the later ones.
        const Deadline deadline(start_, s_.job.time_budget_s, (behind + mine) / whole);
        Group<Scalar> group(s_, pass, region, places, deadline);
        group.run([&](double part, std::optional<double> error_max) {
            s_.account.report_progress((behind + part * mine) / whole, error_max);
        });
        done_ += places.size();
    }

    const Sampling& s_;
    const Clock::time_point start_ = Clock::now();
    std::size_t planned_ = 0, done_ = 0;
};

}  // namespace

void sample_adaptively(const Sampling& sampling) { Adaptive(sampling).run(); }

}  // namespace kiln
