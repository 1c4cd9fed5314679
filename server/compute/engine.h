// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "server/compute/backend.h"
#include "server/compute/report.h"
#include "server/compute/table.h"
#include "server/spec/job_spec.h"

namespace kiln {

class Backend;
class OpenClBackend;

struct Progress {
    double fraction = 0;                       ///< of the work, 0…1
    std::optional<double> standard_error_max;  ///< so far, where at least two replicates exist
};

/// How a running job talks to whoever started it. Both are called from the thread that called
/// run(), at least every 0.2 s while it works.
struct Control {
    std::function<void(const Progress&)> progress = [](const Progress&) {};
    std::function<bool()> cancelled = [] { return false; };
};

struct EngineOptions {
    DeviceChoice device = DeviceChoice::automatic;  ///< upper bound on what a job may ask for
    /// How long an "auto" job waits for an OpenCL program that is still being built before native
    /// takes it.
    std::chrono::milliseconds opencl_wait{0};
    /// Not empty: OpenCL is not touched, and reports give this reason (the supervisor's circuit
    /// breaker).
    std::string opencl_disabled_reason;
    unsigned thread_count = 0;  ///< of the native backend; 0 = every core this process may use
};

struct DeviceInfo {
    std::string backend, name, vendor, version, numerics;
    unsigned compute_units = 0;
    bool usable = true;
    std::string detail;  ///< why it is not usable, or what is special about it
};

struct Outcome {
    Table table;
    std::vector<std::vector<float>> standard_errors;  ///< as Table::planes; only on demand
    Report report;  ///< run_time_s.queued and .encode, quantisation_max and job are the caller's to
                    ///< fill in
};

/// Integrates jobs. One job at a time; run() may be called from any one thread at a time.
class Engine {
  public:
    explicit Engine(EngineOptions options);
    ~Engine();

    /// Starts building the OpenCL program of the default job in the background.
    void warm_up();
    /// Throws Cancelled, or Error("device_failed" | "device_unavailable" | "non_finite").
    /// A quadrature has no standard errors: Outcome::standard_errors stays empty.
    Outcome run(const JobSpec& job, const Control& control, bool standard_error_planes = false);

    /// Where some work was done.
    struct Place {
        DeviceReport device;
        double compile_s = 0;
    };
    /// Hands `work` a backend that has these programs: OpenCL where `device` and the options let
    /// it, else native. What OpenCL fails at is done once more on native, unless OpenCL was asked
    /// for by name. Throws as run() does, and what `work` throws.
    Place run_on(DeviceChoice device, std::span<const KernelKind> kernels, const Control& control,
                 const std::function<void(Backend&)>& work);
    std::vector<DeviceInfo> devices();

    /// The backends themselves, for studies that look at single samples.
    Backend& native();
    std::string native_name() const;
    /// OpenCL with these programs built, where options and `device` let it; else null, and `reason`
    /// says why. Throws Cancelled.
    std::shared_ptr<OpenClBackend> opencl(DeviceChoice device, std::span<const KernelKind> kernels,
                                          const Control& control, std::string& reason);

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace kiln
