// SPDX-License-Identifier: Apache-2.0
#include "server/compute/integrate.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>

#include "server/base/error.h"
#include "server/compute/rare_events.h"
#include "server/compute/replicates.h"
#include "server/compute/texels.h"
#include "server/spec/layouts.h"

namespace kiln {

namespace {

using Clock = std::chrono::steady_clock;

/// Samples a device call may take: milliseconds, so that cancelling and progress are prompt, and
/// the sums that it hands over are still in cache when they are added up.
constexpr std::uint64_t kLaunchSamples = 1u << 23;

/// By how much calls and blocks must be smaller where a sample costs more: a walk takes as long as
/// some hundred samples of a lobe, and a call of it still less than 0.1 s on two cores.
std::size_t cost_of(PointKind kind) { return kind == PointKind::facet_walk ? 16 : 1; }

double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

/// The error so far at one sample count, over all blocks and passes.
struct TraceLevel {
    double elapsed_s = 0;
    ErrorSummary error;
};

/// Where a share's means are found among the combinations of its pass; `both` is a + b, from which
/// their covariance follows, and stands for a where there is no b.
struct SharedCombinations {
    std::size_t a, b, both;
};

/// The combinations that the shares of a pass need, each once.
class Combinations {
  public:
    explicit Combinations(const std::vector<Share>& shares) {
        for (const Share& share : shares) {
            SharedCombinations found{index(share.a), 0, 0};
            found.b = found.both = found.a;
            if (terms_of(share.b) != 0) {
                found.b = index(share.b);
                Combination sum = share.a;
                for (std::size_t t = 0; t < kTermCount; ++t) sum[t] += share.b[t];
                found.both = index(sum);
            }
            shares_.push_back(found);
        }
    }
    const std::vector<Combination>& list() const { return list_; }
    const SharedCombinations& of(std::size_t share) const { return shares_[share]; }

  private:
    std::size_t index(const Combination& combination) {
        const auto at = std::find(list_.begin(), list_.end(), combination);
        if (at != list_.end()) return static_cast<std::size_t>(at - list_.begin());
        list_.push_back(combination);
        return list_.size() - 1;
    }
    std::vector<Combination> list_;
    std::vector<SharedCombinations> shares_;
};

/// What is known of a channel while its passes run.
struct ChannelState {
    std::size_t shares = 0;
    ErrorSummary error;
    std::vector<double> variances;  // a texel, where several shares meet
};

/// One job's way through passes, blocks and launches.
class Integration {
  public:
    Integration(const JobSpec& job, const Plan& plan, Backend& backend, ThreadPool& pool,
                const Control& control, bool standard_error_planes)
        : job_(job), plan_(plan), backend_(backend), pool_(pool), control_(control), texels_(job) {
        for (const Pass& pass : plan.passes)
            samples_planned_ += pass.places.count() * samples_a_place();
        Table& table = outcome_.table;
        table.width = texels_.width();
        table.height = texels_.height();
        for (const Channel& channel : plan.channels) table.channels.push_back(channel.name);
        const std::vector<float> plane(table.width * table.height);
        table.planes.assign(plan.channels.size(), plane);
        if (standard_error_planes) outcome_.standard_errors.assign(plan.channels.size(), plane);
        channels_.resize(plan.channels.size());
        for (const Pass& pass : plan.passes)
            for (const Share& share : pass.shares) ++channels_[share.channel].shares;
    }

    Outcome run() {
        for (const Pass& pass : plan_.passes) {
            if (job_.precision == Precision::float64)
                run_pass<double>(pass);
            else
                run_pass<float>(pass);
        }
        for (const Exact& exact : plan_.exact)
            texels_.fill(outcome_.table.planes[exact.channel], exact.value);
        fill_report();
        return std::move(outcome_);
    }

  private:
    std::uint64_t samples_a_place() const { return static_cast<std::uint64_t>(job_.sample_count); }

    template <typename Scalar>
    void run_pass(const Pass& pass) {
        if (points_kind_ != pass.points)
            points_ = make_points(job_.sampler, pass.points, job_.seed, job_.sample_count);
        points_kind_ = pass.points;
        const std::size_t block =
            std::min(backend_.block_places() / cost_of(pass.points),
                     (pass.places.count() + kLanesMax - 1) / kLanesMax * kLanesMax);
        const Combinations combinations(pass.shares);
        Replicates replicates(combinations.list(), pass.what.material.terms, block);
        const std::vector<Scalar> points(points_.values.begin(), points_.values.end());
        const std::vector<Scalar> parameters(pass.parameters.begin(), pass.parameters.end());
        std::vector<Scalar> texels(2 * block), sums;
        for (std::size_t first = 0; first < pass.places.count(); first += block) {
            const std::size_t count = std::min(block, pass.places.count() - first);
            std::vector<double> deficits(count);
            pool_.parallel_for(block / kLanesMax, [&](std::size_t group) {
                for (std::size_t i = group * kLanesMax; i < (group + 1) * kLanesMax; ++i) {
                    const std::size_t place =
                        first + std::min(i, count - 1);  // lanes past the end repeat the last
                    const double NoV = pass.places.NoV(place), alpha = pass.places.alpha(place);
                    texels[i] = static_cast<Scalar>(NoV);
                    texels[block + i] = static_cast<Scalar>(alpha);
                    if (i < count && pass.points == PointKind::visible_normals)
                        deficits[i] = expected_deficit(pass.what.material, NoV, alpha);
                }
            });
            replicates.reset(std::move(deficits));
            run_block<Scalar>(Launch<Scalar>{pass.what, block, texels, points, parameters, {}, {}},
                              replicates, sums);
            for (std::size_t s = 0; s < pass.shares.size(); ++s)
                store(pass, pass.shares[s], combinations.of(s), replicates, first);
            count_work(pass, replicates);
        }
    }

    template <typename Scalar>
    void run_block(Launch<Scalar> launch, Replicates& replicates, std::vector<Scalar>& sums) {
        const std::size_t stride = launch.texel_stride;
        const std::size_t planes = static_cast<std::size_t>(
            __builtin_popcount(static_cast<unsigned>(launch.what.material.terms)));
        auto started = Clock::now();
        double elapsed = 0;
        for (std::size_t first = 0; first < points_.batches.size();) {
            const std::size_t count = launch_batches(first, stride);
            sums.resize(std::max(sums.size(), count * planes * stride));
            launch.batches = std::span(points_.batches).subspan(first, count);
            launch.sums = std::span(sums).first(count * planes * stride);
            backend_.run(launch);
            replicates.add(pool_, points_, first, count, std::span<const Scalar>(sums));
            first += count;
            elapsed += seconds_since(started);
            std::optional<double> error_max;
            if (is_trace_level(replicates, first)) error_max = add_trace(replicates, elapsed);
            report_progress(count_samples(first - count, count) * replicates.place_count(),
                            error_max);
            started = Clock::now();
        }
        if (const std::uint64_t bad = replicates.non_finite(); bad != 0)
            throw Error("non_finite",
                        std::to_string(bad) + " values of the table are not finite numbers");
        outcome_.report.run_time_s.integrate += elapsed;
    }

    /// Batches of the next call: bounded work, and none past the next level of the trace.
    std::size_t launch_batches(std::size_t first, std::size_t stride) const {
        const std::uint32_t replicate = points_.replicate_of_batch[first];
        std::uint32_t level = 2;
        while (level <= replicate) level *= 2;
        std::size_t count = 0;
        std::uint64_t samples = 0;
        const std::uint64_t cost = stride * cost_of(*points_kind_);
        for (std::size_t b = first;
             b < points_.batches.size() && points_.replicate_of_batch[b] < level; ++b, ++count) {
            samples += points_.batches[b].point_count * cost;
            if (count > 0 && samples > kLaunchSamples) break;
        }
        return count;
    }

    std::uint64_t count_samples(std::size_t first, std::size_t count) const {
        std::uint64_t samples = 0;
        for (std::size_t b = first; b < first + count; ++b)
            samples += points_.batches[b].point_count;
        return samples;
    }

    /// Levels of the trace are powers of two of complete replicates, and the last.
    bool is_trace_level(const Replicates& replicates, std::size_t batches_done) const {
        const std::size_t n = replicates.completed();
        const bool half_done = points_.replicate_of_batch[batches_done - 1] == n;
        return !half_done &&
               (n == points_.replicate_sizes.size() || (n >= 2 && (n & (n - 1)) == 0));
    }

    double add_trace(const Replicates& replicates, double elapsed) {
        TraceLevel& level = trace_[replicates.samples()];
        level.elapsed_s += elapsed;
        ErrorSummary here;
        for (std::size_t c = 0; c < replicates.combination_count(); ++c)
            here.add(replicates.summary(pool_, c));
        level.error.add(here);
        return here.max;
    }

    void report_progress(std::uint64_t samples, std::optional<double> error_max) {
        samples_done_ += samples;
        if (error_max && points_.replicate_sizes.size() > 1) error_so_far_ = error_max;
        control_.progress(
            {static_cast<double>(samples_done_) / static_cast<double>(samples_planned_),
             error_so_far_});
        if (control_.cancelled()) throw Cancelled();
    }

    void count_work(const Pass& pass, const Replicates& replicates) {
        Work& work = outcome_.report.work;
        const int terms = pass.what.material.terms;
        const std::uint64_t samples = replicates.place_count() * samples_a_place();
        work.brdf_evaluations += samples;
        const int per_channel[] = {1 << kSchlick,    1 << kColour,      2 << kColour,
                                   4 << kColour,     1 << kTransmitted, 2 << kTransmitted,
                                   4 << kTransmitted};
        for (const int term : per_channel)
            if (terms & term) work.fresnel_evaluations += samples;
        if (terms & 1 << kDeficit) work.multiscatter_evaluations += samples;
    }

    /// A block's share of a channel into its planes.
    void store(const Pass& pass, const Share& share, const SharedCombinations& means,
               const Replicates& replicates, std::size_t first) {
        ChannelState& channel = channels_[share.channel];
        // What several passes make up together has one error: each texel's, once all are in.
        if (channel.shares > 1 && channel.variances.empty())
            channel.variances.resize(outcome_.table.planes[share.channel].size());
        for (std::size_t i = 0; i < replicates.place_count(); ++i) {
            double value = replicates.mean(means.a, i), variance = replicates.variance(means.a, i);
            if (share.part) {
                const double b = means.both == means.a ? 0 : replicates.mean(means.b, i);
                const Part part = share.part(first + i, value, b);
                double spread = part.by_a * part.by_a * variance;
                if (means.both != means.a) {
                    const double of_b = replicates.variance(means.b, i);
                    const double twice = replicates.variance(means.both, i) - variance - of_b;
                    spread += part.by_b * (part.by_b * of_b + part.by_a * twice);
                }
                value = part.value;
                variance = std::max(spread, 0.0) + part.variance;
            }
            if (channel.shares == 1) channel.error.add(variance, pass.slices.size());
            for (const std::size_t slice : pass.slices)
                texels_.each(
                    pass.what.material.averaged != 0, slice, first + i,
                    [&](std::size_t texel) { add_texel(share.channel, texel, value, variance); });
        }
    }

    void add_texel(std::size_t channel, std::size_t texel, double value, double variance) {
        std::vector<double>& variances = channels_[channel].variances;
        if (!variances.empty()) variance = variances[texel] += variance;
        float& at = outcome_.table.planes[channel][texel];
        at = static_cast<float>(at + value);
        if (!outcome_.standard_errors.empty())
            outcome_.standard_errors[channel][texel] = static_cast<float>(std::sqrt(variance));
    }

    void fill_report() {
        Report& report = outcome_.report;
        report.warnings = plan_.warnings;
        report.samples_per_texel = job_.sample_count;
        report.samples_total = samples_done_;
        report.replicates = static_cast<std::int64_t>(points_.replicate_sizes.size());
        const bool known = plan_.passes.empty() || report.replicates > 1;
        if (!known)
            report.warnings.push_back(
                "one sample a texel leaves no replicates to compare: no error can be estimated");
        for (std::size_t channel = 0; channel < channels_.size(); ++channel) {
            ChannelError error{outcome_.table.channels[channel], {}, {}, {}, {}, {}, {}};
            ErrorSummary& summary = channels_[channel].error;
            for (const double variance : channels_[channel].variances) summary.add(variance, 1);
            if (known) {
                error.standard_error_rms = summary.rms();
                error.standard_error_max = summary.max;
            }
            report.error.push_back(std::move(error));
        }
        for (const auto& [samples, level] : trace_) {
            TraceRow row{static_cast<std::int64_t>(samples), level.elapsed_s, {}, {}};
            if (known) {
                row.standard_error_rms = level.error.rms();
                row.standard_error_max = level.error.max;
            }
            report.trace.push_back(row);
        }
    }

    const JobSpec& job_;
    const Plan& plan_;
    Backend& backend_;
    ThreadPool& pool_;
    const Control& control_;
    PointSet points_;  // of the kind below: slices and averages share them
    std::optional<PointKind> points_kind_;
    Outcome outcome_;
    std::vector<ChannelState> channels_;
    const Texels texels_;
    std::map<std::uint64_t, TraceLevel> trace_;
    std::uint64_t samples_planned_ = 0, samples_done_ = 0;
    std::optional<double> error_so_far_;
};

}  // namespace

Outcome integrate(const JobSpec& job, const Plan& plan, Backend& backend, ThreadPool& pool,
                  const Control& control, bool standard_error_planes) {
    return Integration(job, plan, backend, pool, control, standard_error_planes).run();
}

}  // namespace kiln
