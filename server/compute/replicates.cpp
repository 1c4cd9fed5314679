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

/// The control: E by visible normals, and D.
KILN_WIDE void subtract_controlled(const float* __restrict weights,
                                   const float* __restrict deficits,
                                   const double* __restrict control, double* __restrict partial,
                                   std::size_t count) {
    for (std::size_t i = 0; i < count; ++i)
        partial[i] -=
            control[i] * (static_cast<double>(weights[i]) + static_cast<double>(deficits[i]));
}

KILN_WIDE void subtract_controlled(const double* __restrict weights,
                                   const double* __restrict deficits,
                                   const double* __restrict control, double* __restrict partial,
                                   std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) partial[i] -= control[i] * (weights[i] + deficits[i]);
}

/// Adds batch `row` of a mean's terms, at places from `begin` on.
template <typename Scalar>
void add_batch(const Mean& mean, const std::vector<double>& control, const TermSums<Scalar>& sums,
               std::size_t row, std::size_t begin, double* partial, std::size_t count) {
    const auto plane = [&](std::size_t t) { return sums.data[t] + row * sums.step[t] + begin; };
    for (std::size_t t = 0; t < kTermCount; ++t)
        if (mean.terms[t] != 0) add_scaled(plane(t), mean.terms[t], partial, count);
    if (!control.empty())
        subtract_controlled(plane(kWeight), plane(kDeficit), &control[begin], partial, count);
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

KILN_WIDE void scale_spreads(const double* __restrict spread, double scale, double* __restrict out,
                             std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) out[i] = spread[i] * scale;
}

KILN_WIDE void add_rare_events(const double* __restrict chances, const double* __restrict weights,
                               double samples, double* __restrict out, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i)
        out[i] = with_rare_events(out[i], weights[i] * weights[i] * chances[i] / samples,
                                  chances[i] * samples);
}

/// Variances of the means of places [begin, begin + count) into `out`, from spreads and, where they
/// count, the rare events' share.
void variances(const PlaceFacts& facts, std::size_t mean, std::size_t begin, const double* spread,
               double scale, double samples, double* out, std::size_t count) {
    scale_spreads(spread, scale, out, count);
    if (!facts.event_chances[mean].empty())
        add_rare_events(&facts.event_chances[mean][begin], &facts.event_weights[mean][begin],
                        samples, out, count);
}

/// What stands beside the sums in a mean.
double beside(const Mean& mean, const std::vector<double>& control, std::size_t place) {
    return mean.constant + (control.empty() ? 0 : control[place]);
}

double missable(const PlaceFacts& facts, std::size_t mean, std::size_t place,
                std::uint64_t samples) {
    // Beside log-uniform tangents the variance that stands for rare events exceeds what they carry.
    if (facts.event_chances[mean].empty() || !facts.controls[mean].empty()) return 0;
    const double chance = facts.event_chances[mean][place];
    const bool seen = chance * static_cast<double>(samples) >= kRareEventsSeen;
    return seen ? 0 : facts.event_weights[mean][place] * chance;
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

Replicates::Replicates(std::vector<Mean> means) : means_(std::move(means)) {
    for (auto* planes : {&partial_, &mean_, &spread_}) planes->resize(means_.size());
}

void Replicates::reset(PlaceFacts facts) {
    facts_ = std::move(facts);
    completed_ = 0;
    weight_ = 0;
    for (auto* planes : {&partial_, &mean_, &spread_})
        for (auto& plane : *planes) plane.assign(place_count(), 0.0);
}

template <typename Scalar>
void Replicates::add(ThreadPool& pool, const PointSet& set, std::size_t first, std::size_t count,
                     const TermSums<Scalar>& sums) {
    std::vector<Step> steps;
    for (std::size_t b = first; b < first + count; ++b) {
        const std::uint32_t replicate = set.replicate_of_batch[b];
        const bool last = b + 1 == set.batches.size() || set.replicate_of_batch[b + 1] != replicate;
        const std::uint32_t size = set.replicate_sizes[replicate];
        if (last) {
            weight_ += size;
            ++completed_;
        }
        steps.push_back(
            {b - first, last, 1.0 / size, static_cast<double>(size), static_cast<double>(weight_)});
    }
    pool.parallel_for(task_count(place_count()), [&](std::size_t task) {
        const std::size_t begin = task * kPlacesATask;
        add_places(steps, sums, begin, std::min(begin + kPlacesATask, place_count()));
    });
}

template <typename Scalar>
void Replicates::add_places(const std::vector<Step>& steps, const TermSums<Scalar>& sums,
                            std::size_t begin, std::size_t end) {
    for (std::size_t m = 0; m < means_.size(); ++m) {
        for (const Step& step : steps) {
            add_batch(means_[m], facts_.controls[m], sums, step.row, begin, &partial_[m][begin],
                      end - begin);
            if (step.completes)
                fold_replicate({step.inverse_size, step.weight, step.weight / step.weight_after},
                               &partial_[m][begin], &mean_[m][begin], &spread_[m][begin],
                               end - begin);
        }
    }
}

template void Replicates::add(ThreadPool&, const PointSet&, std::size_t, std::size_t,
                              const TermSums<float>&);
template void Replicates::add(ThreadPool&, const PointSet&, std::size_t, std::size_t,
                              const TermSums<double>&);

void Replicates::fill_variances(std::size_t mean, std::size_t begin, std::size_t end,
                                double* out) const {
    const auto samples = static_cast<double>(weight_);
    const double scale = 1 / (samples * static_cast<double>(completed_ - 1));
    variances(facts_, mean, begin, &spread_[mean][begin], scale, samples, out, end - begin);
}

void Replicates::estimates(std::size_t mean, std::size_t begin, std::span<Estimate> out) const {
    std::vector<double> variance(out.size());
    if (completed_ >= 2) fill_variances(mean, begin, begin + out.size(), variance.data());
    for (std::size_t i = 0; i < out.size(); ++i) {
        const std::size_t place = begin + i;
        out[i] = {beside(means_[mean], facts_.controls[mean], place) + mean_[mean][place],
                  variance[i], missable(facts_, mean, place, weight_)};
    }
}

ErrorSummary Replicates::summary(ThreadPool& pool, std::size_t mean) const {
    ErrorSummary whole;
    whole.count = place_count();
    if (completed_ < 2) return whole;
    std::vector<ErrorSummary> parts(task_count(place_count()));
    pool.parallel_for(parts.size(), [&](std::size_t task) {
        const std::size_t begin = task * kPlacesATask,
                          end = std::min(begin + kPlacesATask, place_count());
        std::array<double, kPlacesATask> variance;
        fill_variances(mean, begin, end, variance.data());
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
        for (std::size_t i = 0; i < place_count(); ++i) count += std::isfinite(plane[i]) ? 0u : 1u;
    return count;
}

GrowingReplicates::GrowingReplicates(std::vector<Mean> means, PlaceFacts facts)
    : means_(std::move(means)), facts_(std::move(facts)) {
    const std::vector<double> plane(facts_.place_count);
    totals_.assign(means_.size() * kReplicatesMax, plane);
    scratch_.resize(totals_.size());
    mean_.assign(means_.size(), plane);
    variance_ = mean_;
    samples_.resize(plane.size());
    for (auto* planes : {&here_.controls, &here_.event_chances, &here_.event_weights})
        planes->resize(means_.size());
}

Estimate GrowingReplicates::estimate(std::size_t mean, std::size_t slot) const {
    return {mean_[mean][slot], variance_[mean][slot], missable(facts_, mean, slot, samples_[slot])};
}

void GrowingReplicates::begin(std::span<const std::uint32_t> slots, bool fresh) {
    slots_.assign(slots.begin(), slots.end());
    const auto gather = [&](const std::vector<double>& from, std::vector<double>& to) {
        to.resize(slots_.size());
        for (std::size_t i = 0; i < slots_.size(); ++i) to[i] = from[slots_[i]];
    };
    here_.place_count = slots_.size();
    for (const auto planes :
         {&PlaceFacts::controls, &PlaceFacts::event_chances, &PlaceFacts::event_weights})
        for (std::size_t m = 0; m < means_.size(); ++m)
            if (!(facts_.*planes)[m].empty()) gather((facts_.*planes)[m], (here_.*planes)[m]);
    for (std::size_t k = 0; k < totals_.size(); ++k) {
        if (fresh)
            scratch_[k].assign(slots_.size(), 0.0);
        else
            gather(totals_[k], scratch_[k]);
    }
}

template <typename Scalar>
void GrowingReplicates::add(ThreadPool& pool, const PointSet& set, std::size_t first,
                            std::size_t count, const TermSums<Scalar>& sums) {
    pool.parallel_for(task_count(slots_.size()), [&](std::size_t task) {
        const std::size_t begin = task * kPlacesATask;
        const std::size_t places = std::min(kPlacesATask, slots_.size() - begin);
        for (std::size_t m = 0; m < means_.size(); ++m)
            for (std::size_t b = 0; b < count; ++b)
                add_batch(means_[m], here_.controls[m], sums, b, begin,
                          &scratch(m, set.replicate_of_batch[first + b])[begin], places);
    });
}

template void GrowingReplicates::add(ThreadPool&, const PointSet&, std::size_t, std::size_t,
                                     const TermSums<float>&);
template void GrowingReplicates::add(ThreadPool&, const PointSet&, std::size_t, std::size_t,
                                     const TermSums<double>&);

void GrowingReplicates::commit(ThreadPool& pool, const PointSet& set) {
    pool.parallel_for(task_count(slots_.size()), [&](std::size_t task) {
        const std::size_t begin = task * kPlacesATask;
        commit_slots(set, begin, std::min(begin + kPlacesATask, slots_.size()));
    });
}

void GrowingReplicates::commit_slots(const PointSet& set, std::size_t begin, std::size_t end) {
    const std::size_t count = end - begin, replicates = set.replicate_sizes.size();
    std::array<double, kPlacesATask> mean, spread, variance;
    for (std::size_t i = begin; i < end; ++i) samples_[slots_[i]] = set.samples();
    for (std::size_t m = 0; m < means_.size(); ++m) {
        mean.fill(0);
        spread.fill(0);
        variance.fill(0);
        double weight = 0;
        for (std::size_t r = 0; r < replicates; ++r) {
            std::vector<double>& total = scratch(m, r);
            for (std::size_t i = begin; i < end; ++i)
                totals_[m * kReplicatesMax + r][slots_[i]] = total[i];
            const double size = set.replicate_sizes[r];
            weight += size;
            fold_replicate({1.0 / size, size, size / weight}, &total[begin], mean.data(),
                           spread.data(), count);
        }
        if (replicates >= 2)
            variances(here_, m, begin, spread.data(),
                      1 / (weight * static_cast<double>(replicates - 1)), weight, variance.data(),
                      count);
        for (std::size_t i = 0; i < count; ++i) {
            mean_[m][slots_[begin + i]] = beside(means_[m], here_.controls[m], begin + i) + mean[i];
            variance_[m][slots_[begin + i]] = variance[i];
        }
    }
}

}  // namespace kiln
