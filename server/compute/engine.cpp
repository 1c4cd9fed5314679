// SPDX-License-Identifier: Apache-2.0
#include "server/compute/engine.h"

#include <algorithm>

#include "server/base/error.h"
#include "server/compute/averages.h"
#include "server/compute/exactness.h"
#include "server/compute/integrate.h"
#include "server/compute/native.h"
#include "server/compute/opencl_programs.h"
#include "server/compute/plan.h"
#include "server/compute/quadrature_job.h"
#include "server/compute/region.h"

namespace kiln {

namespace {

using Clock = std::chrono::steady_clock;

/// The device that runs a job, or why it is not the one that was asked for.
struct Choice {
    std::shared_ptr<OpenClBackend> opencl;  // null: native
    std::optional<std::string> fallback;
    double compile_s = 0;
};

/// What Engine::run was asked for.
struct Request {
    const JobSpec& job;
    const Plan& plan;
    const Control& control;
    bool standard_error_planes;
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

    DeviceChoice wanted(DeviceChoice asked) const {
        if (asked == DeviceChoice::opencl && options.device == DeviceChoice::native)
            throw Error(
                "device_unavailable",
                "this service runs on the native backend alone; ask for \"auto\" or \"native\"");
        return asked == DeviceChoice::automatic ? options.device : asked;
    }

    Choice choose(DeviceChoice asked, std::span<const KernelKind> kernels, const Control& control) {
        const DeviceChoice device = wanted(asked);
        if (device == DeviceChoice::native) return {};
        if (!options.opencl_disabled_reason.empty())
            return refuse(device, options.opencl_disabled_reason);
        const auto start = Clock::now();
        for (const KernelKind& kernel : kernels) opencl().request(kernel);
        const auto keep_waiting = [&] {
            control.progress({});
            if (control.cancelled()) throw Cancelled();
            return device == DeviceChoice::opencl || Clock::now() - start < options.opencl_wait;
        };
        Choice choice;
        for (const KernelKind& kernel : kernels) {
            const bool patient = device == DeviceChoice::opencl || options.opencl_wait.count() > 0;
            const auto answer =
                patient ? opencl().wait(kernel, keep_waiting) : opencl().look(kernel);
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

    Outcome run_on(Backend& backend, const Request& request) {
        const auto& [job, plan, control, standard_error_planes] = request;
        if (job.integrator == Integrator::quadrature)
            return integrate_by_quadrature(
                job, plan, backend, pool, job.target_error.value_or(kQuadratureTolerance), control);
        return integrate(job, plan, backend, pool, control, standard_error_planes);
    }

    static DeviceReport report_of(const OpenClBackend& backend,
                                  std::span<const KernelKind> kernels) {
        std::string numerics = kStrictNumerics;
        for (const KernelKind& kernel : kernels)
            if (backend.numerics(kernel) != kStrictNumerics) numerics = backend.numerics(kernel);
        return {"opencl", backend.name(), numerics, {}};
    }

    static std::vector<KernelKind> kernels_of(const JobSpec& job, const Plan& plan) {
        if (job.integrator == Integrator::quadrature) return quadrature_kernels(job, plan);
        std::vector<KernelKind> kernels;
        for (const Pass& pass : plan.passes)
            for (const Specialisation& kernel : kiln::kernels_of(pass, job.sample_count))
                kernels.push_back(kernel);
        return kernels;
    }

    Place native_place(const Choice& choice) const {
        return {{"native", native_name(), kStrictNumerics, choice.fallback}, choice.compile_s};
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
    const Request request{job, plan, control, standard_error_planes};
    Outcome outcome;
    const Place place =
        run_on(job.device, State::kernels_of(job, plan), control,
               [&](Backend& backend) { outcome = state_->run_on(backend, request); });
    outcome.report.device = place.device;
    hold_against_quadrature(job, outcome, *state_->native, state_->pool, control);
    auto& left_out = outcome.report.left_out;
    left_out.insert(left_out.begin(), plan.left_out.begin(), plan.left_out.end());
    outcome.report.run_time_s.compile = place.compile_s;
    return outcome;
}

Engine::Place Engine::run_on(DeviceChoice device, std::span<const KernelKind> kernels,
                             const Control& control, const std::function<void(Backend&)>& work) {
    Choice choice = state_->choose(device, kernels, control);
    if (choice.opencl) {
        try {
            work(*choice.opencl);
            return {State::report_of(*choice.opencl, kernels), choice.compile_s};
        } catch (const Cancelled&) {
            throw;
        } catch (const Error& error) {
            const std::string& code = error.code();
            if (code != "device_failed" && code != "device_unavailable" && code != "non_finite")
                throw;
            // Of a job whose own values are not finite native throws too: no fault of the device.
            if (code == "non_finite") work(*state_->native);
            state_->opencl().device_failed(error.what());
            choice = State::refuse(state_->wanted(device), error.what());
            if (code == "non_finite") return state_->native_place(choice);
        }
    }
    work(*state_->native);
    return state_->native_place(choice);
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

Backend& Engine::native() { return *state_->native; }
std::string Engine::native_name() const { return state_->native_name(); }

std::shared_ptr<OpenClBackend> Engine::opencl(DeviceChoice device,
                                              std::span<const KernelKind> kernels,
                                              const Control& control, std::string& reason) {
    reason = state_->options.opencl_disabled_reason;
    if (state_->wanted(device) == DeviceChoice::native) reason = "native was asked for";
    if (!reason.empty()) return nullptr;
    const auto stay_in_touch = [&] {
        control.progress({});
        if (control.cancelled()) throw Cancelled();
        return true;
    };
    std::shared_ptr<OpenClBackend> backend;
    for (const KernelKind& what : kernels) state_->opencl().request(what);
    for (const KernelKind& what : kernels) {
        const auto answer = state_->opencl().wait(what, stay_in_touch);
        reason = answer.reason;
        if (!answer.backend) return nullptr;
        backend = answer.backend;
    }
    return backend;
}

}  // namespace kiln
