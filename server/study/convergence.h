// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "server/spec/job_spec.h"
#include "server/study/study.h"

/// What the files of the convergence study share; nobody outside includes this.
namespace kiln::convergence {

/// Seeds of one point of a curve: their spread is what a run more could change.
inline constexpr std::uint64_t kRuns = 3;

struct Recipe {
    DeviceChoice device = DeviceChoice::native;
    Sampler sampler = Sampler::sobol_owen;
    Importance importance = Importance::vndf;
    auto operator<=>(const Recipe&) const = default;
};

/// One recipe at one sample count, over all its runs.
struct Measured {
    std::int64_t sample_count = 0;
    std::array<double, kRuns> seconds{};
    double error_rms = 0, error_max = 0, standard_error_rms = 0;

    double median() const {
        std::array<double, kRuns> sorted = seconds;
        std::sort(sorted.begin(), sorted.end());
        return sorted[kRuns / 2];
    }
    double least() const { return *std::min_element(seconds.begin(), seconds.end()); }
    double most() const { return *std::max_element(seconds.begin(), seconds.end()); }
};

struct Curves {
    std::map<Recipe, std::vector<Measured>> sampled;
    std::map<DeviceChoice, std::vector<Measured>> quadrature;
};

std::vector<Chart> charts_of(const Curves& curves);

}  // namespace kiln::convergence
