// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "server/compute/estimate.h"
#include "server/compute/points.h"
#include "server/compute/thread_pool.h"

namespace kiln {

/// Standard errors gathered over places and channels.
struct ErrorSummary {
    double sum_of_squares = 0, max = 0;
    std::uint64_t count = 0;

    void add(const ErrorSummary& other);
    /// `times` values of one variance.
    void add(double variance, std::uint64_t times);
    double rms() const;
};

/// Running mean and spread of the replicate means at a block of places. Batches come in the order
/// of the points, in any split; the result depends on neither split nor thread count.
class Replicates {
  public:
    explicit Replicates(std::vector<Mean> means);

    /// Starts over, for the places of `facts`.
    void reset(PlaceFacts facts);

    /// Adds the batches [first, first + count) of `set`.
    template <typename Scalar>
    void add(ThreadPool& pool, const PointSet& set, std::size_t first, std::size_t count,
             const TermSums<Scalar>& sums);

    std::size_t completed() const { return completed_; }  ///< replicates
    std::uint64_t samples() const { return weight_; }     ///< a place, in completed replicates
    std::size_t place_count() const { return facts_.place_count; }
    /// Of places from `begin` on. The variance is 0 while fewer than two replicates are complete.
    void estimates(std::size_t mean, std::size_t begin, std::span<Estimate> out) const;
    std::size_t mean_count() const { return means_.size(); }
    ErrorSummary summary(ThreadPool& pool, std::size_t mean) const;
    std::uint64_t non_finite() const;  ///< means that are not finite

  private:
    struct Step {                     // one batch as every place sees it
        std::size_t row;              // batch within sums
        bool completes;               // its replicate
        double inverse_size;          // 1 / points of the replicate
        double weight, weight_after;  // points of the replicate, of all with it
    };
    void fill_variances(std::size_t mean, std::size_t begin, std::size_t end, double* out) const;
    template <typename Scalar>
    void add_places(const std::vector<Step>& steps, const TermSums<Scalar>& sums, std::size_t begin,
                    std::size_t end);

    std::vector<Mean> means_;
    PlaceFacts facts_;
    std::size_t completed_ = 0;
    std::uint64_t weight_ = 0;
    std::vector<std::vector<double>> partial_, mean_, spread_;  // [mean][place]
};

/// The same means, by replicates that all grow together: each level lengthens every one of them at
/// some of the places. The bits at a number of samples are those of Replicates at that number,
/// whatever the other places do.
class GrowingReplicates {
  public:
    GrowingReplicates(std::vector<Mean> means, PlaceFacts facts);

    /// Takes up a level at these places; `fresh`: with points that replace the earlier ones.
    void begin(std::span<const std::uint32_t> slots, bool fresh);
    template <typename Scalar>
    void add(ThreadPool& pool, const PointSet& set, std::size_t first, std::size_t count,
             const TermSums<Scalar>& sums);
    /// The level is whole: its places stand at as many samples as the replicates of `set` have.
    void commit(ThreadPool& pool, const PointSet& set);

    Estimate estimate(std::size_t mean, std::size_t slot) const;
    std::uint64_t samples(std::size_t slot) const { return samples_[slot]; }
    std::size_t mean_count() const { return means_.size(); }

  private:
    std::vector<double>& scratch(std::size_t mean, std::size_t replicate) {
        return scratch_[mean * kReplicatesMax + replicate];
    }
    void commit_slots(const PointSet& set, std::size_t begin, std::size_t end);

    std::vector<Mean> means_;
    PlaceFacts facts_, here_;
    std::vector<std::uint32_t> slots_;
    std::vector<std::vector<double>> totals_;           // [mean · replicates + replicate][slot]
    std::vector<std::vector<double>> scratch_;          // the same, at slots_
    std::vector<std::vector<double>> mean_, variance_;  // [mean][slot]
    std::vector<std::uint64_t> samples_;                // [slot]
};

}  // namespace kiln
