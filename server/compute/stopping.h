// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <vector>

#include "server/compute/estimate.h"
#include "server/compute/plan.h"
#include "server/spec/job_spec.h"

namespace kiln {

/// Samples a texel, in all replicates, at which a job's errors are looked at: doublings from 1024
/// on (under a budget of time from 64 on, so that each place has its first value soon), and
/// sample_count.
std::vector<std::int64_t> level_samples(const JobSpec& job);

/// The moment at which a part of a job's time has passed.
class Deadline {
  public:
    Deadline(std::chrono::steady_clock::time_point start, std::optional<double> budget_s,
             double part);
    bool passed() const;

  private:
    std::optional<std::chrono::steady_clock::time_point> end_;
};

/// What a place has to reach.
class StoppingRules {
  public:
    explicit StoppingRules(const JobSpec& job) : job_(job) {}

    bool aims() const { return job_.target_error.has_value(); }
    double floor() const { return rounding_floor(job_.precision); }
    /// Bound that each of a channel's shares must keep: target_error, or a quarter of what pixels
    /// resolve at this value, divided among them. 0 without a target.
    double tolerance(std::size_t shares, double value) const;
    bool is_quantum(double value) const { return quantum(value) / 4 > *job_.target_error; }
    /// Three doublings of the samples lie between the two errors; nothing is said of zeros.
    bool is_flat(double before, double now) const;

  private:
    double quantum(double value) const;
    const JobSpec& job_;
};

/// All shares of a place at one level.
struct LevelVerdict {
    bool passes = true, at_roundoff = false, at_quantum = false;
    double bound = 0, error = 0;  ///< largest
    /// `shares`: of the share's channel.
    void add(const StoppingRules& rules, const Pass& pass, const Share& share, std::size_t shares,
             std::size_t place, const Estimate& estimate);
};

/// How far a place has come. It stops at the second level in a row that passes: replicates that
/// agree by chance at the first one would end every fourth run in error where rare events carry
/// the integral. Below α = 0.1 the replicates must hold 256 points as well.
struct Progressed {
    bool stopped = false, passed = false, at_roundoff = false, at_quantum = false;
    std::size_t levels = 0;
    double bound = 0;
    std::array<double, 4> errors{};  ///< standard errors of the last levels, latest first
    void add(const LevelVerdict& verdict, const StoppingRules& rules, double alpha,
             std::uint64_t samples);
};

}  // namespace kiln
