// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "server/compute/region.h"

namespace kiln {

/// A mean of some combination of terms, or what a share makes of two.
struct Estimate {
    double value = 0;
    double variance = 0;  ///< of the value, rare events included; 0 while nothing is known of it
    /// What rare events carry, where fewer than kRareEventsSeen of them are expected.
    double missable = 0;

    double standard_error() const { return std::sqrt(variance); }
};

/// 95 % of errors lie within this many standard errors of 16 replicates, 15 degrees of freedom.
inline constexpr double kStudentT = 2.131;

/// What rounding may add to a mean, which no replicate sees: of float sums of at most 1024, and of
/// the float that a mean is stored in.
constexpr double rounding_floor(Precision precision) {
    return precision == Precision::float32 ? 2e-6 : 3e-8;
}

/// What is averaged at each place: a combination of sums, and what puts it right where log-uniform
/// tangents know the deficit better than visible normals do.
struct Mean {
    Combination terms{};
    double constant = 0;
    /// Coefficients of what visible normals draw, T, beside a deficit D by log-uniform tangents: T
    /// + M (1 − W − D), with M the value of T where light is lost (lost_VoH). Rare events, which
    /// carry no T, leave T + M (1 − W) at M; they count in D alone.
    Combination mirrored{};
    bool operator==(const Mean& other) const {
        return terms == other.terms && constant == other.constant && mirrored == other.mirrored;
    }
};

/// What the means of some places need to know of them, each [mean][place] or empty where it is 0.
struct PlaceFacts {
    std::size_t place_count = 0;
    std::vector<std::vector<double>> controls;  ///< Σ mirrored · M
    /// Rare events (rare_events.h): the probability of one in a sample, and what it weighs.
    std::vector<std::vector<double>> event_chances, event_weights;
};

/// The means that the shares of a pass need in a region, each once.
class Means {
  public:
    Means(const std::vector<Share>& shares, const Region& region);
    const std::vector<Mean>& list() const { return list_; }

    /// Of a share: where its two means stand, and that of their sum, from which their covariance
    /// follows. All three are a where there is no b.
    struct OfShare {
        std::size_t a, b, both;
    };
    const OfShare& of(std::size_t share) const { return shares_[share]; }

    /// What a share makes of its means at a place. at(mean) → Estimate.
    template <typename At>
    Estimate estimate(const Share& share, std::size_t index, std::size_t place, At at) const {
        const OfShare& means = shares_[index];
        const Estimate a = at(means.a);
        if (!share.part) return a;
        if (means.both == means.a) {
            const Part part = share.part(place, a.value, 0);
            return {part.value, part.by_a * part.by_a * a.variance + part.variance,
                    std::abs(part.by_a) * a.missable};
        }
        const Estimate b = at(means.b);
        const Part part = share.part(place, a.value, b.value);
        const double twice = at(means.both).variance - a.variance - b.variance;
        const double spread = part.by_a * part.by_a * a.variance +
                              part.by_b * (part.by_b * b.variance + part.by_a * twice);
        return {part.value, std::max(spread, 0.0) + part.variance,
                std::abs(part.by_a) * a.missable + std::abs(part.by_b) * b.missable};
    }

    /// Of the places of a region with these means.
    PlaceFacts facts(const Pass& pass, const Region& region, ThreadPool& pool,
                     std::span<const std::uint32_t> places) const;

  private:
    std::size_t index(const Combination& combination, const Region& region);
    std::vector<Mean> list_;
    std::vector<OfShare> shares_;
};

}  // namespace kiln
