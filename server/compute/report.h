// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace kiln {

/// What a job cost and how good its result is. Field names are those of the contract's JSON
/// (api/openapi.json). An optional that is empty becomes null: the figure does not exist, which
/// differs from zero.
struct ChannelError {
    std::string quantity;
    std::optional<double> standard_error_rms;  ///< over all texels; from independent replicates
    std::optional<double> standard_error_max;
    std::optional<double> reference_rms;  ///< difference from quadrature, where one exists
    std::optional<double> reference_max;
    std::optional<double> reconstruction_max;        ///< what bilinear lookup adds between texels
    std::optional<double> quantisation_max;          ///< what the pixel type adds
    std::optional<std::int64_t> reference_texels{};  ///< that were held against quadrature
};

struct TraceRow {
    std::int64_t sample_count = 0;  ///< a texel
    double elapsed_s = 0;           ///< of integration, up to that many samples at every texel
    std::optional<double> standard_error_rms;
    std::optional<double> standard_error_max;
};

struct DeviceReport {
    std::string backend;                  ///< "opencl" or "native"
    std::string name;                     ///< device or instruction set
    std::string numerics;                 ///< numerics class: equal classes give equal bits
    std::optional<std::string> fallback;  ///< why the job did not run where it was asked to
};

struct RunTime {
    double queued = 0, compile = 0, integrate = 0;
    double assemble = 0;  ///< points, regions, and putting means and errors into the table
    double reference = 0, encode = 0, total = 0;
};

struct Work {
    std::uint64_t brdf_evaluations = 0, fresnel_evaluations = 0, multiscatter_evaluations = 0;
};

struct LeftOut {
    std::string what;
    std::string why;
};

struct Report {
    std::string job;  ///< job id
    std::string status = "done";
    DeviceReport device;
    std::int64_t samples_per_texel = 0;
    std::uint64_t samples_total = 0;
    std::int64_t replicates = 0;  ///< independent randomisations behind each standard error
    RunTime run_time_s;
    std::vector<ChannelError> error;
    std::vector<TraceRow> trace;
    Work work;
    std::vector<LeftOut> left_out;
    std::vector<std::string> warnings;
};

/// The contract's JSON text of a report. Throws Error("non_finite") rather than write null for a
/// number.
std::string to_json(const Report& report);

}  // namespace kiln
