// SPDX-License-Identifier: Apache-2.0
#include "server/compute/replicates.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "server/compute/rare_events.h"

namespace kiln {

namespace {
/// Places that one task works on: its doubles stay in the first-level cache.
constexpr std::size_t kPlacesATask = 512;

std::size_t task_count(std::size_t places) { return (places + kPlacesATask - 1) / kPlacesATask; }

// The loops over places, at the widest vectors that the CPU has: the same bits, since contraction
// is off and each place is its own sum.
#define KILN_WIDE __attribute__((target_clones("default", "arch=x86-64-v3", "arch=x86-64-v4")))

KILN_WIDE void add_scaled(const float* __restrict sums, double coefficient,
                          double* __restrict partial, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i)
        partial[i] += coefficient * static_cast<double>(sums[i]);
}

KILN_WIDE void add_scaled(const double* __restrict sums, double coefficient,
                          double* __restrict partial, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) partial[i] += coefficient * sums[i];
}

struct ReplicateWeight {
    double inverse_size, weight, share;
};

/// West 1979: weighted running mean and sum of squared deviations.
KILN_WIDE void fold_replicate(ReplicateWeight w, double* __restrict partial,
                              double* __restrict mean, double* __restrict spread,
                              std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
        const double value = partial[i] * w.inverse_size;
        const double off = value - mean[i];
        mean[i] += off * w.share;
        spread[i] += w.weight * off * (value - mean[i]);
        partial[i] = 0;
    }
}

/// Variances of the means into `out`, from spreads and, where they count, the rare events' share.
KILN_WIDE void variances(const double* __restrict spread, const double* __restrict deficits,
                         double scale, double samples, double* __restrict out, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i)
        out[i] = spread[i] * scale +
                 (deficits == nullptr ? 0.0 : rare_event_variance(deficits[i], samples));
}
}  // namespace

void ErrorSummary::add(const ErrorSummary& other) {
    sum_of_squares += other.sum_of_squares;
    max = std::max(max, other.max);
    count += other.count;
}

void ErrorSummary::add(double variance, std::uint64_t times) {
    sum_of_squares += variance * static_cast<double>(times);
    max = std::max(max, std::sqrt(variance));
    count += times;
}

double ErrorSummary::rms() const {
    return count == 0 ? 0 : std::sqrt(sum_of_squares / static_cast<double>(count));
}

Replicates::Replicates(std::vector<Combination> coefficients, int terms,
                       std::size_t stride)
    : coefficients_(std::move(coefficients)), planes_(kTermCount), stride_(stride) {
    for (std::size_t t = 0; t < kTermCount; ++t)
        if (terms >> t & 1) planes_[t] = plane_count_++;
    for (auto* planes : {&partial_, &mean_, &spread_}) planes->resize(coefficients_.size());
}

void Replicates::reset(std::vector<double> deficits) {
    place_count_ = deficits.size();
    deficits_ = std::move(deficits);
    completed_ = 0;
    weight_ = 0;
    for (auto* planes : {&partial_, &mean_, &spread_})
        for (auto& plane : *planes) plane.assign(place_count_, 0.0);
}

template <typename Scalar>
void Replicates::add(ThreadPool& pool, const PointSet& set, std::size_t first, std::size_t count,
                     std::span<const Scalar> sums) {
    std::vector<Step> steps;
    for (std::size_t b = first; b < first + count; ++b) {
        const std::uint32_t replicate = set.replicate_of_batch[b];
        const bool last = b + 1 == set.batches.size() || set.replicate_of_batch[b + 1] != replicate;
        const std::uint32_t size = set.replicate_sizes[replicate];
        if (last) {
            weight_ += size;
            ++completed_;
        }
        steps.push_back({(b - first) * plane_count_, last, 1.0 / size, static_cast<double>(size),
                         static_cast<double>(weight_)});
    }
    pool.parallel_for(task_count(place_count_), [&](std::size_t task) {
        const std::size_t begin = task * kPlacesATask;
        add_places(steps, sums, begin, std::min(begin + kPlacesATask, place_count_));
    });
}

template <typename Scalar>
void Replicates::add_places(const std::vector<Step>& steps, std::span<const Scalar> sums,
                            std::size_t begin, std::size_t end) {
    for (std::size_t q = 0; q < coefficients_.size(); ++q) {
        for (const Step& step : steps) {
            for (std::size_t t = 0; t < kTermCount; ++t)
                if (coefficients_[q][t] != 0)
                    add_scaled(sums.data() + (step.row + planes_[t]) * stride_ + begin,
                               coefficients_[q][t], &partial_[q][begin], end - begin);
            if (step.completes)
                fold_replicate({step.inverse_size, step.weight, step.weight / step.weight_after},
                               &partial_[q][begin], &mean_[q][begin], &spread_[q][begin],
                               end - begin);
        }
    }
}

template void Replicates::add(ThreadPool&, const PointSet&, std::size_t, std::size_t,
                              std::span<const float>);
template void Replicates::add(ThreadPool&, const PointSet&, std::size_t, std::size_t,
                              std::span<const double>);

void Replicates::fill_variances(std::size_t combination, std::size_t begin, std::size_t end,
                                double* out) const {
    const auto& c = coefficients_[combination];
    // E and 1 − E; B has no weight there.
    const bool feels_rare_events = c[kWeight] != 0 || c[kDeficit] != 0 || c[kColour] != 0 ||
                                   c[kColour + 1] != 0 || c[kColour + 2] != 0;
    const auto samples = static_cast<double>(weight_);
    const double scale = 1 / (samples * static_cast<double>(completed_ - 1));
    variances(&spread_[combination][begin], feels_rare_events ? &deficits_[begin] : nullptr, scale,
              samples, out, end - begin);
}

double Replicates::variance(std::size_t combination, std::size_t place) const {
    if (completed_ < 2) return 0;
    double variance = 0;
    fill_variances(combination, place, place + 1, &variance);
    return variance;
}

ErrorSummary Replicates::summary(ThreadPool& pool, std::size_t combination) const {
    ErrorSummary whole;
    whole.count = place_count_;
    if (completed_ < 2) return whole;
    std::vector<ErrorSummary> parts(task_count(place_count_));
    pool.parallel_for(parts.size(), [&](std::size_t task) {
        const std::size_t begin = task * kPlacesATask,
                          end = std::min(begin + kPlacesATask, place_count_);
        std::array<double, kPlacesATask> variance;
        fill_variances(combination, begin, end, variance.data());
        double sum = 0, max = 0;
        for (std::size_t i = 0; i < end - begin; ++i) {
            sum += variance[i];
            max = std::max(max, variance[i]);
        }
        parts[task].sum_of_squares = sum;
        parts[task].max = std::sqrt(max);
    });
    for (const ErrorSummary& part : parts) whole.add(part);
    return whole;
}

std::uint64_t Replicates::non_finite() const {
    std::uint64_t count = 0;
    for (const auto& plane : mean_)
        for (std::size_t i = 0; i < place_count_; ++i) count += std::isfinite(plane[i]) ? 0u : 1u;
    return count;
}

}  // namespace kiln
