// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "server/compute/engine.h"
#include "server/spec/channels.h"
#include "tests/reference/reference.h"

// What the engine bakes, beside quadrature that shares no line with its kernels.
namespace kiln::against_reference {

// Rounding of float32 arithmetic and storage, which no replicate sees: about 2e-6 where batches of
// at most 1024 samples are summed in double.
inline constexpr double kRounding = 2e-6;

using Values = std::vector<double>;

inline Axis axis(Parameter parameter, Grid grid = Grid::center, Mapping mapping = Mapping::linear) {
    Axis a;
    a.parameter = parameter;
    a.grid = grid;
    a.mapping = mapping;
    return a;
}

inline JobSpec square_job(std::vector<Quantity> quantities, std::int64_t size,
                          std::int64_t sample_count) {
    JobSpec job;
    job.quantities = std::move(quantities);
    job.resolution = {size, size};
    job.axes = {axis(Parameter::NoV), axis(Parameter::roughness)};
    job.sample_count = sample_count;
    job.device = DeviceChoice::native;
    return job;
}

inline Outcome bake(const JobSpec& job) {
    EngineOptions options;
    options.device = DeviceChoice::native;
    Engine engine(options);
    Outcome outcome = engine.run(job, Control{}, /*standard_error_planes=*/true);
    EXPECT_EQ(outcome.table.planes.size(), channels_of(job).size());
    EXPECT_EQ(outcome.standard_errors.size(), channels_of(job).size());
    return outcome;
}

/// The parameter at every texel of an axis, written from the contract's words: centres at (i + 1/2)
/// / n, nodes at i / (n - 1); "sqrt" is linear in sqrt(p), "square" in p^2; flip turns the order
/// round.
inline Values positions(const Axis& a, std::int64_t count) {
    const auto warp = [&](double p) {
        if (a.mapping == Mapping::linear) return p;
        return a.mapping == Mapping::sqrt ? std::sqrt(p) : p * p;
    };
    Values values;
    for (std::int64_t i = 0; i < count; ++i) {
        const double index = static_cast<double>(i), n = static_cast<double>(count);
        const double t = a.grid == Grid::center ? (index + .5) / n : index / (n - 1);
        const double warped = warp(a.lo) * (1 - t) + warp(a.hi) * t;
        const double p = a.mapping == Mapping::linear ? warped
                         : a.mapping == Mapping::sqrt ? warped * warped
                                                      : std::sqrt(warped);
        values.push_back(std::clamp(p, 0., 1.));
    }
    if (a.flip) std::reverse(values.begin(), values.end());
    return values;
}

inline reference::Quantity reference_of(Quantity quantity) {
    switch (quantity) {
        case Quantity::split_sum_scale:
            return reference::Quantity::scale;
        case Quantity::split_sum_bias:
            return reference::Quantity::bias;
        case Quantity::directional_albedo:
            return reference::Quantity::directional;
        case Quantity::average_albedo:
            return reference::Quantity::average;
        case Quantity::multiscatter_albedo:
            return reference::Quantity::multiscatter;
        default:
            break;  // has no table in the reference
    }
    throw std::logic_error("unknown quantity");
}

inline bool carries_NoV(const Axis& a) { return a.parameter == Parameter::NoV; }

/// Exact values in the layout of Table::planes; the job has two axes, one of them NoV.
inline Values exact(const JobSpec& job, Quantity quantity) {
    const bool NoV_on_x = carries_NoV(job.axes[0]);
    const Values x = positions(job.axes[0], job.resolution[0]);
    const Values y = positions(job.axes[1], job.resolution[1]);
    Values NoV = NoV_on_x ? x : y, alpha = NoV_on_x ? y : x;
    if (job.axes[NoV_on_x ? 1 : 0].parameter == Parameter::roughness)
        for (double& r : alpha) r *= r;
    const auto masking = job.masking == Masking::smith_correlated ? reference::Masking::correlated
                                                                  : reference::Masking::separable;
    const Values rows = reference::table(reference_of(quantity), masking, NoV, alpha);
    if (NoV_on_x) return rows;
    Values turned;
    for (std::size_t i = 0; i < NoV.size(); ++i)
        for (std::size_t j = 0; j < alpha.size(); ++j) turned.push_back(rows[j * NoV.size() + i]);
    return turned;
}

struct Errors {
    double rms = 0, max = 0;
    double inside = 0;  ///< share of texels within five reported standard errors and the rounding
    std::size_t count = 0;
};

/// Over the texels whose row lies at y >= y_min. Fails on the first value that is not finite.
inline Errors compare(const JobSpec& job, const Outcome& outcome, std::size_t channel,
                      const Values& truth, double y_min = 0) {
    const Values y = positions(job.axes[1], job.resolution[1]);
    const auto width = static_cast<std::size_t>(job.resolution[0]);
    Errors errors;
    for (std::size_t i = 0; i < truth.size(); ++i) {
        if (y[i / width] < y_min) continue;
        const double value = outcome.table.planes[channel][i];
        const double standard_error = outcome.standard_errors[channel][i];
        if (!std::isfinite(value) || !std::isfinite(standard_error) || standard_error < 0) {
            ADD_FAILURE() << "texel " << i << ": " << value << " +- " << standard_error;
            return {};
        }
        const double error = std::abs(value - truth[i]);
        errors.rms += error * error;
        errors.max = std::max(errors.max, error);
        errors.inside += error <= 5 * standard_error + kRounding ? 1 : 0;
        ++errors.count;
    }
    const double count = static_cast<double>(errors.count);
    EXPECT_GT(errors.count, 0U);
    errors.rms = std::sqrt(errors.rms / count);
    errors.inside /= count;
    return errors;
}

inline const std::vector<Quantity> kAll = {Quantity::split_sum_scale, Quantity::split_sum_bias,
                                           Quantity::directional_albedo, Quantity::average_albedo,
                                           Quantity::multiscatter_albedo};

}  // namespace kiln::against_reference
