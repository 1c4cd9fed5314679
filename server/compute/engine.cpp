// SPDX-License-Identifier: Apache-2.0
#include "server/compute/engine.h"

#include <algorithm>

#include "server/base/error.h"
#include "server/compute/averages.h"
#include "server/compute/integrate.h"
#include "server/compute/native.h"
#include "server/compute/opencl_programs.h"
#include "server/compute/plan.h"
#include "server/compute/quadrature_job.h"

namespace kiln {

namespace {

using Clock = std::chrono::steady_clock;

/// The device that runs a job, or why it is not the one that was asked for.
struct Choice {
    std::shared_ptr<OpenClBackend> opencl;  // null: native
    std::optional<std::string> fallback;
    double compile_s = 0;
};

}  // namespace

struct Engine::State {
    EngineOptions options;
    ThreadPool pool;
    InstructionSet instruction_set = usable_instruction_sets().front();
    std::unique_ptr<Backend> native;
    std::unique_ptr<OpenClPrograms>
        programs;  // made on first use: a job for native never touches OpenCL

    explicit State(EngineOptions given)
        : options(std::move(given)),
          pool(options.thread_count),
          native(make_native_backend(pool, instruction_set)) {}

    OpenClPrograms& opencl() {
        if (!programs) programs = std::make_unique<OpenClPrograms>();
        return *programs;
    }

    DeviceChoice wanted(const JobSpec& job) const {
        if (job.device == DeviceChoice::opencl && options.device == DeviceChoice::native)
            throw Error(
                "device_unavailable",
                "this service runs on the native backend alone; ask for \"auto\" or \"native\"");
        return job.device == DeviceChoice::automatic ? options.device : job.device;
    }

    Choice choose(const JobSpec& job, const Plan& plan, const Control& control) {
        const DeviceChoice device = wanted(job);
        if (device == DeviceChoice::native) return {};
        if (!options.opencl_disabled_reason.empty())
            return refuse(device, options.opencl_disabled_reason);
        const auto start = Clock::now();
        for (const Pass& pass : plan.passes) opencl().request(pass.what);
        const auto keep_waiting = [&] {
            control.progress({});
            if (control.cancelled()) throw Cancelled();
            return device == DeviceChoice::opencl || Clock::now() - start < options.opencl_wait;
        };
        Choice choice;
        for (const Pass& pass : plan.passes) {
            const bool patient = device == DeviceChoice::opencl || options.opencl_wait.count() > 0;
            const auto answer =
                patient ? opencl().wait(pass.what, keep_waiting) : opencl().look(pass.what);
            if (!answer.backend) return refuse(device, answer.reason);
            choice.opencl = answer.backend;
        }
        choice.compile_s = std::chrono::duration<double>(Clock::now() - start).count();
        return choice;
    }

    /// "opencl" by name fails where "auto" goes on with native.
    static Choice refuse(DeviceChoice device, const std::string& reason) {
        if (device == DeviceChoice::opencl) throw Error("device_unavailable", reason);
        return {nullptr, reason, 0};
    }

    Outcome run_on_opencl(const JobSpec& job, const Plan& plan, const Control& control,
                          bool standard_error_planes, OpenClBackend& backend) {
        Outcome outcome = integrate(job, plan, backend, pool, control, standard_error_planes);
        std::string numerics = kStrictNumerics;
        for (const Pass& pass : plan.passes)
            if (backend.numerics(pass.what) != kStrictNumerics)
                numerics = backend.numerics(pass.what);
        outcome.report.device = {"opencl", backend.name(), numerics, {}};
        return outcome;
    }

    Outcome run_on_native(const JobSpec& job, const Plan& plan, const Control& control,
                          bool standard_error_planes, const std::optional<std::string>& fallback) {
        Outcome outcome = integrate(job, plan, *native, pool, control, standard_error_planes);
        outcome.report.device = {"native", native_name(), kStrictNumerics, fallback};
        return outcome;
    }

    std::string native_name() const {
        return to_string(instruction_set) + ", " + std::to_string(pool.size()) + " threads";
    }
};

Engine::Engine(EngineOptions options) : state_(std::make_unique<State>(std::move(options))) {}
Engine::~Engine() = default;

void Engine::warm_up() {
    if (state_->options.device == DeviceChoice::native ||
        !state_->options.opencl_disabled_reason.empty())
        return;
    JobSpec common;
    common.quantities = {Quantity::split_sum_scale, Quantity::split_sum_bias};
    common.resolution = {1, 1};
    common.axes = {Axis{}, Axis{.parameter = Parameter::roughness}};
    for (const Pass& pass : make_plan(common, [] { return Averages{}; }).passes)
        state_->opencl().request(pass.what);
}

Outcome Engine::run(const JobSpec& job, const Control& control, bool standard_error_planes) {
    const Plan plan = make_plan(
        job, [&] { return average_deficits(job, *state_->native, state_->pool, control); });
    if (job.integrator == Integrator::quadrature) {
        Outcome outcome = integrate_by_quadrature(job, plan, *state_->native, control);
        outcome.report.device = {"native", state_->native_name(), kStrictNumerics, {}};
        outcome.report.left_out = plan.left_out;
        return outcome;
    }
    Choice choice = state_->choose(job, plan, control);
    Outcome outcome;
    if (choice.opencl) {
        try {
            outcome =
                state_->run_on_opencl(job, plan, control, standard_error_planes, *choice.opencl);
        } catch (const Cancelled&) {
            throw;
        } catch (const Error& error) {
            state_->opencl().device_failed(error.what());
            choice = State::refuse(state_->wanted(job), error.what());
        }
    }
    if (outcome.table.planes.empty())
        outcome = state_->run_on_native(job, plan, control, standard_error_planes, choice.fallback);
    outcome.report.left_out = plan.left_out;
    outcome.report.run_time_s.compile = choice.compile_s;
    return outcome;
}

std::vector<DeviceInfo> Engine::devices() {
    std::vector<DeviceInfo> infos;
    infos.push_back(
        {"native", state_->native_name(), "", "", kStrictNumerics, state_->pool.size(), true, ""});
    // A driver that crashed its process is not asked again while OpenCL is switched off.
    if (state_->options.device == DeviceChoice::native ||
        !state_->options.opencl_disabled_reason.empty()) {
        const std::string& reason = state_->options.opencl_disabled_reason;
        infos.push_back({"opencl", "none", "", "", "", 0, false,
                         reason.empty() ? "jobs run on native alone" : reason});
        return infos;
    }
    try {
        for (DeviceInfo& info : opencl_devices()) infos.push_back(std::move(info));
    } catch (const Error& error) {
        infos.push_back({"opencl", "none", "", "", "", 0, false, error.what()});
    }
    return infos;
}

}  // namespace kiln
