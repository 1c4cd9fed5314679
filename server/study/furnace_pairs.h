// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "server/compute/axes.h"
#include "server/compute/engine.h"
#include "server/spec/channels.h"

// What a furnace study looks at, before it judges: tables, and f(V, L) at pairs of directions.
namespace kiln {

/// The largest of something, and where it was found.
struct Extreme {
    double value;
    double roughness = 0, NoV = 0, NoL = 0;
};

/// The tables that the study is made of, row by row of roughness.
class FurnaceTables {
  public:
    FurnaceTables(const JobSpec& job, Outcome outcome)
        : channels_(channels_of(job)), axes_(job.axes), outcome_(std::move(outcome)) {}

    std::size_t angles() const { return outcome_.table.width; }
    std::size_t roughnesses() const { return outcome_.table.height; }
    double NoV(std::size_t x) const { return on_axis(0, x, angles()); }
    double roughness(std::size_t y) const { return on_axis(1, y, roughnesses()); }

    /// How many colours a quantity has here: 1 or 3.
    int colours(Quantity quantity) const {
        return static_cast<int>(
            std::count_if(channels_.begin(), channels_.end(),
                          [&](const Channel& channel) { return channel.quantity == quantity; }));
    }
    double value(Quantity quantity, int colour, std::size_t x, std::size_t y) const {
        return outcome_.table.planes[index(quantity, colour)][y * angles() + x];
    }
    double standard_error(Quantity quantity, int colour, std::size_t x, std::size_t y) const {
        return outcome_.standard_errors[index(quantity, colour)][y * angles() + x];
    }
    std::vector<double> row(Quantity quantity, int colour, std::size_t y) const {
        std::vector<double> values;
        if (colours(quantity) == 0) return values;
        for (std::size_t x = 0; x < angles(); ++x) values.push_back(value(quantity, colour, x, y));
        return values;
    }
    const Report& report() const { return outcome_.report; }

  private:
    double on_axis(std::size_t axis, std::size_t i, std::size_t count) const {
        return axis_value(axes_[axis], static_cast<std::int64_t>(i),
                          static_cast<std::int64_t>(count));
    }
    std::size_t index(Quantity quantity, int colour) const {
        for (std::size_t c = 0; c < channels_.size(); ++c)
            if (channels_[c].quantity == quantity &&
                channels_[c].colour == std::min(colour, colours(quantity) - 1))
                return c;
        __builtin_unreachable();
    }
    std::vector<Channel> channels_;
    std::vector<Axis> axes_;
    Outcome outcome_;
};

/// Pairs of directions at each roughness; a million and more in all.
inline constexpr int kPairs = 1 << 17;
/// Between two looks at the clock.
inline constexpr int kPairsALook = 1 << 14;
/// Of light that walks over facets f is a mean: pairs at each roughness, and walks from either side
/// of each. Towards the horizon single walks carry nearly all of it, and their mean is not normal.
inline constexpr int kWalkedPairs = 64, kWalks = 1 << 11;
inline constexpr double kWalkedCosineMin = 0.05;
/// Standard errors that the two sides of some thousand pairs may be apart.
inline constexpr double kDeviationsMax = 6;
/// Relative: the kernels' functions in double differ by some 1e-15 with V and L exchanged.
inline constexpr double kReciprocal = 1e-5;

/// f(V, L) over random pairs of directions at all roughnesses.
struct Pointwise {
    Extreme least{std::numeric_limits<double>::infinity()};
    /// |f(V, L) − f(L, V)| over the greater of the two, or, where f is a mean, over the standard
    /// error of the difference.
    Extreme asymmetry{0};
    double relative_errors = 0;  ///< sum of that error over f
    int walked = 0;              ///< pairs at which f is a mean
};

inline bool walks_over_facets(const JobSpec& job) {
    return job.diffuse.model == DiffuseModel::ggx_lambert;
}

/// Throws Cancelled.
Pointwise look_at_pairs(const JobSpec& job, const FurnaceTables& tables, const Control& control);

}  // namespace kiln
