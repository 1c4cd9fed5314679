// SPDX-License-Identifier: Apache-2.0
#include "server/compute/stopping.h"

#include <algorithm>
#include <cmath>

#include "server/compute/trust.h"

namespace kiln {

std::vector<std::int64_t> level_samples(const JobSpec& job) {
    constexpr std::int64_t kFirstPoints = kFirstBatchPoints, kFirstPointsInTime = 4;
    std::int64_t samples = kReplicatesMax * (job.time_budget_s ? kFirstPointsInTime : kFirstPoints);
    std::vector<std::int64_t> levels;
    for (; samples < job.sample_count; samples *= 2) levels.push_back(samples);
    levels.push_back(job.sample_count);
    return levels;
}

Deadline::Deadline(std::chrono::steady_clock::time_point start, std::optional<double> budget_s,
                   double part) {
    if (budget_s)
        end_ = start + std::chrono::duration_cast<std::chrono::steady_clock::duration>(
                           std::chrono::duration<double>(*budget_s * part));
}

bool Deadline::passed() const { return end_ && std::chrono::steady_clock::now() >= *end_; }

/// The step from one pixel value to the next.
double StoppingRules::quantum(double value) const {
    switch (job_.pixel) {
        case PixelType::half: {
            constexpr int kBits = 10, kExponentMin = -14;
            int exponent = 0;
            std::frexp(value, &exponent);
            return std::ldexp(1.0, std::max(exponent - 1, kExponentMin) - kBits);
        }
        case PixelType::uint8:
            return 1.0 / 255;
        case PixelType::uint16:
            return 1.0 / 65535;
        case PixelType::float32:
        case PixelType::rgb9e5:  // of measured kinds, which have no such figure
            return 0;
    }
    __builtin_unreachable();
}

double StoppingRules::tolerance(std::size_t shares, double value) const {
    if (!job_.target_error) return 0;
    return std::max(*job_.target_error, quantum(value) / 4) / static_cast<double>(shares);
}

bool StoppingRules::is_flat(double before, double now) const {
    // log2 of a standard error of 16 replicates has a deviation of 0.26, so a slope over three
    // doublings one of 0.12: three of them above the order of the points.
    const double slope_max = job_.sampler == Sampler::random ? -0.15 : -0.4;
    return before > 0 && now > 0 && std::log2(now / before) / 3 > slope_max;
}

void LevelVerdict::add(const StoppingRules& rules, const Pass& pass, const Share& share,
                       std::size_t shares, std::size_t place, const Estimate& estimate) {
    if (!rules.aims()) {
        passes = false;
        return;
    }
    const double tolerance = rules.tolerance(shares, estimate.value);
    const double spread = kStudentT * estimate.standard_error();
    bound = std::max(bound, spread + rules.floor());
    error = std::max(error, estimate.standard_error());
    at_quantum |= rules.is_quantum(estimate.value);
    const double allowed = std::max(tolerance, 2 * rules.floor());
    passes &= spread + rules.floor() <= allowed &&
              !lacks_rare_events(estimate, std::max(spread + rules.floor(), tolerance)) &&
              !misses_mirror_limit(pass, share, place, estimate, spread + rules.floor());
    at_roundoff |= spread + rules.floor() > tolerance;
}

void Progressed::add(const LevelVerdict& verdict, const StoppingRules& rules, double alpha,
                     std::uint64_t samples) {
    std::rotate(errors.begin(), errors.end() - 1, errors.end());
    errors[0] = verdict.error;
    bound = verdict.bound;
    ++levels;
    if (!rules.aims()) return;
    constexpr double kSmoothAlpha = 0.1;
    constexpr std::uint64_t kRoughPoints = 256;
    const bool enough = alpha >= kSmoothAlpha || samples >= kRoughPoints * kReplicatesMax;
    stopped = verdict.passes && passed && enough;
    passed = verdict.passes;
    at_roundoff = verdict.at_roundoff;
    at_quantum = verdict.at_quantum;
}

}  // namespace kiln
