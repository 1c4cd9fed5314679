// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <string>
#include <vector>

#include "server/base/error.h"
#include "server/compute/axes.h"
#include "server/compute/quadrature.h"
#include "tests/compute/against_reference.h"
#include "tests/compute/opencl_cache.h"

// Tables of a few places between chosen ends, beside quadrature at the very numbers that the
// kernels get.
namespace kiln::sampled_places {

using against_reference::Values;

struct Ends {
    double lo, hi;
    std::int64_t count;
};

/// Nodes of NoV and α, both denser towards 0; every quantity that has a smooth truth.
inline JobSpec grid_job(const Ends& NoV, const Ends& alpha, std::int64_t sample_count) {
    JobSpec job;
    job.quantities = {Quantity::split_sum_scale, Quantity::split_sum_bias,
                      Quantity::directional_albedo, Quantity::multiscatter_albedo};
    job.resolution = {NoV.count, alpha.count};
    job.axes = {against_reference::axis(Parameter::NoV, Grid::node, Mapping::sqrt),
                against_reference::axis(Parameter::alpha, Grid::node, Mapping::sqrt)};
    job.axes[0].lo = NoV.lo;
    job.axes[0].hi = NoV.hi;
    job.axes[1].lo = alpha.lo;
    job.axes[1].hi = alpha.hi;
    job.sample_count = sample_count;
    job.device = DeviceChoice::native;
    job.pixel = PixelType::float32;
    return job;
}

/// "NoV 0.1 alpha 0.01" of a texel.
inline std::string where(const JobSpec& job, std::size_t texel) {
    const Places places = Places::directional(job);
    return "NoV " + std::to_string(places.NoV(texel)) + " alpha " +
           std::to_string(places.alpha(texel));
}

/// truth[quantity][texel], of the quantities of grid_job(), to 1e-9 and 1e-6 of 1 − E: at the
/// precision's rounding of the place.
inline std::vector<Values> truth_of(const JobSpec& job) {
    const Places places = Places::directional(job);
    std::vector<Values> truth(4);
    for (std::size_t i = 0; i < places.count(); ++i) {
        double NoV = places.NoV(i), alpha = places.alpha(i);
        if (job.precision == Precision::float32) {
            NoV = static_cast<float>(NoV);
            alpha = static_cast<float>(alpha);
        }
        const QuadratureValue exact = quadrature_albedo(NoV, alpha, job.masking);
        truth[0].push_back(exact.E - exact.B);
        truth[1].push_back(exact.B);
        truth[2].push_back(1 - exact.deficit);
        truth[3].push_back(exact.deficit);
    }
    return truth;
}

/// One engine for many small jobs.
class Baker {
  public:
    Baker()
        : engine_([] {
              EngineOptions options;
              options.device = DeviceChoice::native;
              return options;
          }()) {}
    Outcome operator()(const JobSpec& job) {
        return engine_.run(job, Control{}, /*standard_error_planes=*/true);
    }

  private:
    Engine engine_;
};

/// Holds what native baked against OpenCL: the first job of each kind in a process, kinds being
/// jobs that differ in more than the seed. Of long ones the first samples are compared.
class HeldOnOpenCl {
  public:
    void hold(JobSpec job, Baker& bake) {
        constexpr std::int64_t kSamplesMax = 16384;
        job.sample_count = std::min(job.sample_count, kSamplesMax);
        JobSpec kind = job;
        kind.seed = 0;
        if (missing_ || std::ranges::count(kinds_, kind)) return;
        kinds_.push_back(kind);
        const Outcome native = bake(job);
        job.device = DeviceChoice::opencl;
        try {
            compare(engine_.run(job, Control{}, /*standard_error_planes=*/true), native);
        } catch (const Error& error) {
            if (error.code() != "device_unavailable") throw;
            missing_ = true;
            std::printf("nothing is held on OpenCL: %s\n", error.what());
        }
    }

  private:
    static void compare(const Outcome& opencl, const Outcome& native) {
        EXPECT_EQ(opencl.report.device.backend, "opencl");
        EXPECT_EQ(opencl.report.device.numerics, native.report.device.numerics);
        EXPECT_TRUE(opencl.table.planes == native.table.planes);
        EXPECT_TRUE(opencl.standard_errors == native.standard_errors);
    }

    Engine engine_{EngineOptions{}};
    std::vector<JobSpec> kinds_;
    bool missing_ = false;
};

/// As Baker, for figures that are asked of both backends: the same bits make them one figure.
class BakerOnBoth {
  public:
    Outcome operator()(const JobSpec& job) {
        Outcome outcome = bake_(job);
        test::share_opencl_cache();
        static HeldOnOpenCl on_opencl;
        on_opencl.hold(job, bake_);
        return outcome;
    }

  private:
    Baker bake_;
};

inline double log2_slope(const std::vector<double>& errors) {
    // Least squares of log2 error over doublings, whose number is the abscissa.
    const double n = static_cast<double>(errors.size());
    double mean = 0, up = 0, down = 0;
    for (const double error : errors) mean += std::log2(error) / n;
    for (std::size_t i = 0; i < errors.size(); ++i) {
        const double x = static_cast<double>(i) - (n - 1) / 2;
        up += x * (std::log2(errors[i]) - mean);
        down += x * x;
    }
    return up / down;
}

}  // namespace kiln::sampled_places
