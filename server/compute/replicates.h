// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "server/compute/points.h"
#include "server/compute/terms.h"
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

/// Running mean and spread of the replicate means of some combinations at a block of places. Batches
/// come in the order of the points, in any split; the result depends on neither split nor thread
/// count.
class Replicates {
  public:
    /// `coefficients[c]` is combination c of the terms; `stride` is the launch's texel_stride.
    Replicates(std::vector<Combination> coefficients, int terms,
               std::size_t stride);

    /// Starts over, for a block of at most `stride` places. deficits[place] is what rare events
    /// carry there (rare_events.h); 0 where an estimate has none.
    void reset(std::vector<double> deficits);

    /// Adds the batches [first, first + count) of `set`, whose sums are laid out as Launch::sums.
    template <typename Scalar>
    void add(ThreadPool& pool, const PointSet& set, std::size_t first, std::size_t count,
             std::span<const Scalar> sums);

    std::size_t completed() const { return completed_; }  ///< replicates
    std::uint64_t samples() const { return weight_; }     ///< a place, in completed replicates
    std::size_t place_count() const { return place_count_; }
    double mean(std::size_t combination, std::size_t place) const { return mean_[combination][place]; }
    /// Of the mean; 0 while fewer than two replicates are complete.
    double variance(std::size_t combination, std::size_t place) const;
    std::size_t combination_count() const { return coefficients_.size(); }
    ErrorSummary summary(ThreadPool& pool, std::size_t combination) const;
    std::uint64_t non_finite() const;  ///< means that are not finite

  private:
    struct Step {                     // one batch as every place sees it
        std::size_t row;              // first plane of the batch in sums
        bool completes;               // its replicate
        double inverse_size;          // 1 / points of the replicate
        double weight, weight_after;  // points of the replicate, of all with it
    };
    void fill_variances(std::size_t combination, std::size_t begin, std::size_t end,
                        double* out) const;
    template <typename Scalar>
    void add_places(const std::vector<Step>& steps, std::span<const Scalar> sums, std::size_t begin,
                    std::size_t end);

    std::vector<Combination> coefficients_;
    std::vector<std::size_t> planes_;  // term → plane within a batch
    std::size_t plane_count_ = 0, stride_, place_count_ = 0, completed_ = 0;
    std::uint64_t weight_ = 0;
    std::vector<double> deficits_;                              // [place]
    std::vector<std::vector<double>> partial_, mean_, spread_;  // [combination][place]
};

}  // namespace kiln
