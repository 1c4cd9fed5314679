// SPDX-License-Identifier: Apache-2.0
#include "server/compute/replicates.h"

#include <algorithm>
#include <cmath>

#include "server/compute/rare_events.h"

namespace kiln {

namespace {
/// Places that one task works on: its doubles stay in the first-level cache.
constexpr std::size_t kPlacesATask = 512;

std::size_t task_count(std::size_t places) { return (places + kPlacesATask - 1) / kPlacesATask; }
}  // namespace

void ErrorSummary::add(const ErrorSummary& other) {
    sum_of_squares += other.sum_of_squares;
    max = std::max(max, other.max);
    count += other.count;
}

double ErrorSummary::rms() const { return count == 0 ? 0 : std::sqrt(sum_of_squares / static_cast<double>(count)); }

Replicates::Replicates(std::vector<std::array<double, kTermCount>> coefficients, int terms, std::size_t stride)
    : coefficients_(std::move(coefficients)), planes_(kTermCount), stride_(stride) {
    for (std::size_t t = 0; t < kTermCount; ++t)
        if (terms >> t & 1) planes_[t] = plane_count_++;
    for (auto* planes : {&partial_, &mean_, &spread_}) planes->assign(coefficients_.size(), std::vector<double>(stride));
}

void Replicates::reset(std::vector<double> deficits) {
    place_count_ = deficits.size();
    deficits_ = std::move(deficits);
    completed_ = 0;
    weight_ = 0;
    for (auto* planes : {&partial_, &mean_, &spread_})
        for (auto& plane : *planes) std::fill(plane.begin(), plane.end(), 0.0);
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
void Replicates::add_places(const std::vector<Step>& steps, std::span<const Scalar> sums, std::size_t begin,
                            std::size_t end) {
    for (std::size_t q = 0; q < coefficients_.size(); ++q) {
        double* partial = partial_[q].data();
        double* mean = mean_[q].data();
        double* spread = spread_[q].data();
        for (const Step& step : steps) {
            for (std::size_t t = 0; t < kTermCount; ++t) {
                const double coefficient = coefficients_[q][t];
                if (coefficient == 0) continue;
                const Scalar* plane = sums.data() + (step.row + planes_[t]) * stride_;
                for (std::size_t i = begin; i < end; ++i) partial[i] += coefficient * static_cast<double>(plane[i]);
            }
            if (!step.completes) continue;
            // West 1979: weighted running mean and sum of squared deviations.
            const double share = step.weight / step.weight_after;
            for (std::size_t i = begin; i < end; ++i) {
                const double value = partial[i] * step.inverse_size;
                const double off = value - mean[i];
                mean[i] += off * share;
                spread[i] += step.weight * off * (value - mean[i]);
                partial[i] = 0;
            }
        }
    }
}

template void Replicates::add(ThreadPool&, const PointSet&, std::size_t, std::size_t, std::span<const float>);
template void Replicates::add(ThreadPool&, const PointSet&, std::size_t, std::size_t, std::span<const double>);

double Replicates::standard_error(std::size_t quantity, std::size_t place) const {
    if (completed_ < 2) return 0;
    const auto samples = static_cast<double>(weight_);
    const double seen = spread_[quantity][place] / (samples * static_cast<double>(completed_ - 1));
    const auto& c = coefficients_[quantity];
    const bool feels_rare_events = c[0] != 0 || c[2] != 0;  // E and 1 − E; B has no weight there
    const double missed = feels_rare_events ? rare_event_variance(deficits_[place], samples) : 0;
    return std::sqrt(std::max(seen, 0.0) + missed);
}

ErrorSummary Replicates::summary(ThreadPool& pool, std::size_t quantity) const {
    std::vector<ErrorSummary> parts(task_count(place_count_));
    pool.parallel_for(parts.size(), [&](std::size_t task) {
        const std::size_t begin = task * kPlacesATask, end = std::min(begin + kPlacesATask, place_count_);
        for (std::size_t i = begin; i < end; ++i) parts[task].add(standard_error(quantity, i));
    });
    ErrorSummary whole;
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
