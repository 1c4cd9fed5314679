// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "server/compute/engine.h"
#include "server/compute/estimate.h"
#include "server/compute/plan.h"
#include "server/compute/replicates.h"
#include "server/compute/texels.h"

namespace kiln {

/// The error so far at one sample count.
struct TraceLevel {
    std::uint64_t samples = 0;  ///< a texel
    double elapsed_s = 0;
    ErrorSummary error;
};

/// Places of which something is said: how many, and where.
struct PlaceRange {
    std::uint64_t count = 0;
    double NoV_min = 1, NoV_max = 0, alpha_min = 1, alpha_max = 0;
    void add(const Pass& pass, std::size_t place);
    void add(const PlaceRange& other);
    /// "12 places (NoV 0.1…0.2, alpha 0.01)".
    std::string words() const;
};

/// What a job has so far, whichever way it is sampled: planes, errors, trace, work, and what its
/// status will say.
class Account {
  public:
    Account(const JobSpec& job, const Plan& plan, const Control& control,
            bool standard_error_planes);

    /// What was stored of some places of a pass, of each share of it: kept apart, so that several
    /// threads may store, each its own places.
    struct Stored {
        explicit Stored(const Pass& pass) : errors(pass.shares.size()) {}
        std::vector<ErrorSummary> errors;  ///< [share]
        PlaceRange suspected;
    };
    /// One place's part of a channel, once it is final.
    void store(const Pass& pass, std::size_t share, std::size_t place, const Estimate& estimate,
               Stored& stored);
    /// In an order that does not depend on threads: sums of errors are rounded.
    void add(const Pass& pass, const Stored& stored);
    /// `samples` in all, by one kernel.
    void count_work(const Specialisation& what, std::uint64_t samples);
    void count_samples(std::uint64_t samples, std::uint64_t a_texel);
    /// Rising samples, of places of their own.
    void add_trace(std::vector<TraceLevel> levels);
    /// Calls the job's control. Throws Cancelled.
    void report_progress(double fraction, std::optional<double> error_max);
    std::size_t shares_of(std::size_t channel) const { return channels_[channel].shares; }

    /// Which places did not get what was asked for, and why.
    PlaceRange suspected, unconverged, at_roundoff;
    bool trace_is_flat = false, at_quantum = false, out_of_time = false;
    double bound_max = 0;  ///< of the unconverged places
    double integrate_s = 0;
    std::int64_t replicates = 0;

    Outcome finish();

  private:
    /// What is known of a channel while its passes run.
    struct ChannelState {
        std::size_t shares = 0;
        ErrorSummary error;
        std::vector<double> variances;  // a texel, where several shares meet
    };
    void add_texel(std::size_t channel, std::size_t texel, const Estimate& estimate);
    void fill_errors(bool known);
    void fill_trace(bool known);
    void fill_status();

    const JobSpec& job_;
    const Plan& plan_;
    const Control& control_;
    const Texels texels_;
    Outcome outcome_;
    std::vector<ChannelState> channels_;
    std::vector<std::vector<TraceLevel>> traces_;
    std::uint64_t samples_a_texel_ = 0;
    double fraction_ = 0;
    std::optional<double> error_so_far_;
};

}  // namespace kiln
