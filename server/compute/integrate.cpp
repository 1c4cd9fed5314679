// SPDX-License-Identifier: Apache-2.0
#include "server/compute/integrate.h"

#include <algorithm>
#include <chrono>
#include <map>

#include "server/base/error.h"
#include "server/compute/quantity.h"
#include "server/compute/rare_events.h"
#include "server/compute/replicates.h"
#include "server/spec/words.h"

namespace kiln {

namespace {

using Clock = std::chrono::steady_clock;

/// Samples a device call may take: milliseconds, so that cancelling and progress are prompt, and
/// the sums that it hands over are still in cache when they are added up.
constexpr std::uint64_t kLaunchSamples = 1u << 23;

double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

/// The error so far at one sample count, over all blocks and passes.
struct TraceLevel {
    double elapsed_s = 0;
    ErrorSummary error;
};

/// One job's way through passes, blocks and launches.
class Integration {
  public:
    Integration(const JobSpec& job, const Plan& plan, Backend& backend, ThreadPool& pool,
                const Control& control, bool standard_error_planes)
        : job_(job),
          plan_(plan),
          backend_(backend),
          pool_(pool),
          control_(control),
          points_(make_points(job.sampler, job.importance, job.seed, job.sample_count)) {
        for (const Pass& pass : plan.passes)
            samples_planned_ += pass.places.count() * samples_a_place();
        Table& table = outcome_.table;
        table.width = static_cast<std::size_t>(job.resolution[0]);
        table.height = job.resolution.size() > 1 ? static_cast<std::size_t>(job.resolution[1]) : 1;
        for (const Quantity quantity : job.quantities)
            table.channels.emplace_back(to_word(quantity));
        const std::vector<float> plane(table.width * table.height);
        table.planes.assign(job.quantities.size(), plane);
        if (standard_error_planes) outcome_.standard_errors.assign(job.quantities.size(), plane);
        channel_errors_.resize(job.quantities.size());
    }

    Outcome run() {
        for (const Pass& pass : plan_.passes) {
            if (job_.precision == Precision::float64)
                run_pass<double>(pass);
            else
                run_pass<float>(pass);
        }
        fill_report();
        return std::move(outcome_);
    }

  private:
    std::uint64_t samples_a_place() const { return static_cast<std::uint64_t>(job_.sample_count); }

    template <typename Scalar>
    void run_pass(const Pass& pass) {
        const std::size_t block = std::min(
            backend_.block_places(), (pass.places.count() + kLanesMax - 1) / kLanesMax * kLanesMax);
        std::vector<std::array<double, kTermCount>> coefficients;
        for (const std::size_t channel : pass.channels)
            coefficients.push_back(quantity_row(job_.quantities[channel]).coefficients);
        Replicates replicates(std::move(coefficients), pass.what.terms, block);
        const std::vector<Scalar> points(points_.values.begin(), points_.values.end());
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
                    if (i < count && pass.what.importance == Importance::vndf)
                        deficits[i] = expected_deficit(pass.what, NoV, alpha);
                }
            });
            replicates.reset(std::move(deficits));
            run_block<Scalar>(pass, replicates, block, texels, points, sums);
            store_block(pass, replicates, first);
        }
    }

    template <typename Scalar>
    void run_block(const Pass& pass, Replicates& replicates, std::size_t stride,
                   const std::vector<Scalar>& texels, const std::vector<Scalar>& points,
                   std::vector<Scalar>& sums) {
        const std::size_t planes =
            static_cast<std::size_t>(__builtin_popcount(static_cast<unsigned>(pass.what.terms)));
        auto started = Clock::now();
        double elapsed = 0;
        for (std::size_t first = 0; first < points_.batches.size();) {
            const std::size_t count = launch_batches(first, stride);
            sums.resize(std::max(sums.size(), count * planes * stride));
            backend_.run(Launch<Scalar>{pass.what, stride, texels, points,
                                        std::span(points_.batches).subspan(first, count),
                                        std::span(sums).first(count * planes * stride)});
            replicates.add(pool_, points_, first, count, std::span<const Scalar>(sums));
            first += count;
            elapsed += seconds_since(started);
            std::optional<double> error_max;
            if (is_trace_level(replicates, first))
                error_max = add_trace(replicates, elapsed, pass.channels.size());
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
        for (std::size_t b = first;
             b < points_.batches.size() && points_.replicate_of_batch[b] < level; ++b, ++count) {
            samples += points_.batches[b].point_count * stride;
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

    double add_trace(const Replicates& replicates, double elapsed, std::size_t quantity_count) {
        TraceLevel& level = trace_[replicates.samples()];
        level.elapsed_s += elapsed;
        ErrorSummary here;
        for (std::size_t q = 0; q < quantity_count; ++q) here.add(replicates.summary(pool_, q));
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

    void store_block(const Pass& pass, const Replicates& replicates, std::size_t first) {
        for (std::size_t q = 0; q < pass.channels.size(); ++q) {
            const std::size_t channel = pass.channels[q];
            channel_errors_[channel].add(replicates.summary(pool_, q));
            store(pass, outcome_.table.planes[channel], first, replicates,
                  [&](std::size_t i) { return replicates.mean(q, i); });
            if (!outcome_.standard_errors.empty())
                store(pass, outcome_.standard_errors[channel], first, replicates,
                      [&](std::size_t i) { return replicates.standard_error(q, i); });
        }
        Work& work = outcome_.report.work;
        const std::uint64_t samples = replicates.place_count() * samples_a_place();
        work.brdf_evaluations += samples;
        if (pass.what.terms & terms_of(Quantity::split_sum_bias))
            work.fresnel_evaluations += samples;
        if (pass.what.terms & terms_of(Quantity::multiscatter_albedo))
            work.multiscatter_evaluations += samples;
    }

    /// A block's values into a plane; an averaged place fills its whole line of the table.
    template <typename Value>
    void store(const Pass& pass, std::vector<float>& plane, std::size_t first,
               const Replicates& replicates, Value value) const {
        const Table& table = outcome_.table;
        const bool along_x = pass.what.averaged && roughness_axis(job_) == 0;
        for (std::size_t i = 0; i < replicates.place_count(); ++i) {
            const auto texel = static_cast<float>(value(i));
            if (!pass.what.averaged) {
                plane[first + i] = texel;
            } else if (along_x) {
                for (std::size_t y = 0; y < table.height; ++y)
                    plane[y * table.width + first + i] = texel;
            } else {
                std::fill_n(plane.begin() + static_cast<std::ptrdiff_t>((first + i) * table.width),
                            table.width, texel);
            }
        }
    }

    void fill_report() {
        Report& report = outcome_.report;
        report.samples_per_texel = job_.sample_count;
        report.samples_total = samples_done_;
        report.replicates = static_cast<std::int64_t>(points_.replicate_sizes.size());
        const bool known = report.replicates > 1;
        if (!known)
            report.warnings.push_back(
                "one sample a texel leaves no replicates to compare: no error can be estimated");
        for (std::size_t channel = 0; channel < channel_errors_.size(); ++channel) {
            ChannelError error{outcome_.table.channels[channel], {}, {}, {}, {}, {}, {}};
            if (known) {
                error.standard_error_rms = channel_errors_[channel].rms();
                error.standard_error_max = channel_errors_[channel].max;
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
    PointSet points_;
    Outcome outcome_;
    std::vector<ErrorSummary> channel_errors_;
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
