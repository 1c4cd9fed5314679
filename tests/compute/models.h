// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <sstream>
#include <string>
#include <vector>

#include "tests/compute/against_reference.h"
#include "tests/reference/coupling_models.h"

// Every model that a job can name, at eight texels, beside the reference's model of that name.
namespace kiln::models {

using against_reference::bake;
using against_reference::Values;

/// Eight times 2^18, at which every quantity of every model is held to kExact: the long form, asked
/// for by KILN_MODEL_SAMPLES. Twice what a job document may ask for.
inline constexpr std::int64_t kLongSamples = 1 << 21;
/// What each run takes: 16 replicates of 65536 points.
inline constexpr std::int64_t kShortSamples = 1 << 20;
/// What float32 tables are held to where the estimator itself converges that far.
inline constexpr double kExact = 5e-6;

/// Samples a texel.
inline std::int64_t samples() {
    const char* given = std::getenv("KILN_MODEL_SAMPLES");
    return given ? std::stoll(given) : kShortSamples;
}
inline bool long_form() { return samples() >= kLongSamples; }
/// Where an eighth of them does for each run.
inline std::int64_t few_samples() { return long_form() ? samples() : samples() / 8; }

/// NoV .2 … .9 by roughness .475 and .825: middle values, where every sampler covers every lobe.
inline JobSpec model_job(std::vector<Quantity> quantities) {
    JobSpec job;
    job.quantities = std::move(quantities);
    job.resolution = {4, 2};
    job.axes = {against_reference::axis(Parameter::NoV),
                against_reference::axis(Parameter::roughness)};
    job.axes[0].lo = 0.1;
    job.axes[1].lo = 0.3;
    job.sample_count = samples();
    job.device = DeviceChoice::native;
    return job;
}

inline Values roughnesses(const JobSpec& job) {
    return against_reference::positions(job.axes[1], job.resolution[1]);
}

/// at(NoV, roughness) at every texel, in the order of Table::planes.
template <class At>
Values over_texels(const JobSpec& job, const At& at) {
    Values values;
    for (const double roughness : roughnesses(job))
        for (const double NoV : against_reference::positions(job.axes[0], job.resolution[0]))
            values.push_back(at(NoV, roughness));
    return values;
}

/// at(roughness) along every line of a roughness.
template <class At>
Values over_lines(const JobSpec& job, const At& at) {
    Values values;
    for (const double roughness : roughnesses(job))
        values.insert(values.end(), static_cast<std::size_t>(job.resolution[0]), at(roughness));
    return values;
}

/// Each texel within five of its reported standard errors (or kExact, below which rounding in float
/// counts as well), and within `reached`, which is kExact unless the caller derives another.
/// The largest difference goes into the test's record.
inline void hold(const Outcome& outcome, std::size_t channel, const Values& truth,
                 const std::string& label, double reached = kExact) {
    ASSERT_LT(channel, outcome.table.planes.size());
    const auto& plane = outcome.table.planes[channel];
    const auto& standard_errors = outcome.standard_errors[channel];
    ASSERT_EQ(plane.size(), truth.size());
    double most = 0, most_standard_error = 0;
    for (std::size_t i = 0; i < truth.size(); ++i) {
        const double error = std::abs(static_cast<double>(plane[i]) - truth[i]);
        const double standard_error = standard_errors[i];
        most = std::max(most, error);
        most_standard_error = std::max(most_standard_error, standard_error);
        EXPECT_LE(error, std::max(5 * standard_error, kExact))
            << label << ' ' << outcome.table.channels[channel] << " texel " << i << ": " << plane[i]
            << " beside " << truth[i] << ", standard error " << standard_error;
        EXPECT_LE(error, reached) << label << ' ' << outcome.table.channels[channel] << " texel "
                                  << i << ", standard error " << standard_error;
    }
    std::ostringstream figure;
    figure << label << ' ' << outcome.table.channels[channel] << ": " << most << ", standard error "
           << most_standard_error;
    std::string key = "error_" + label + '_' + outcome.table.channels[channel];
    testing::Test::RecordProperty(key, figure.str());
}

}  // namespace kiln::models
