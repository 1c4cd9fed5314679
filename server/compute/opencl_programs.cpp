// SPDX-License-Identifier: Apache-2.0
#include "server/compute/opencl_programs.h"

#include "server/base/error.h"
#include "server/compute/native.h"

namespace kiln {

OpenClPrograms::OpenClPrograms()
    : oracle_(make_native_backend(trial_pool_, usable_instruction_sets().front())),
      thread_([this](const std::stop_token& stop) { work(stop); }) {}

OpenClPrograms::~OpenClPrograms() {
    thread_.request_stop();
    changed_.notify_all();
}

void OpenClPrograms::request(const KernelKind& what) {
    {
        const std::lock_guard lock(mutex_);
        if (!device_reason_.empty() || failures_.contains(what)) return;
        if (backend_ && backend_->built(what)) return;
        wanted_.insert(what);
    }
    changed_.notify_all();
}

OpenClPrograms::Answer OpenClPrograms::look_locked(const KernelKind& what) const {
    if (!device_reason_.empty()) return {nullptr, device_reason_, false};
    if (const auto failure = failures_.find(what); failure != failures_.end())
        return {nullptr, failure->second, false};
    if (backend_ && backend_->built(what)) return {backend_, "", false};
    return {nullptr, "the OpenCL program was still being built", true};
}

OpenClPrograms::Answer OpenClPrograms::look(const KernelKind& what) {
    const std::lock_guard lock(mutex_);
    return look_locked(what);
}

OpenClPrograms::Answer OpenClPrograms::wait(const KernelKind& what,
                                            const std::function<bool()>& keep_waiting) {
    request(what);
    for (;;) {
        {
            std::unique_lock lock(mutex_);
            const Answer answer = look_locked(what);
            if (!answer.pending) return answer;
            changed_.wait_for(lock, std::chrono::milliseconds(50));
        }
        if (!keep_waiting()) return look(what);
    }
}

void OpenClPrograms::device_failed(const std::string& reason) {
    const std::lock_guard lock(mutex_);
    backend_.reset();
    if (++device_failures_ >= kDeviceFailuresMax)
        device_reason_ = "OpenCL failed repeatedly, last: " + reason;
}

void OpenClPrograms::work(const std::stop_token& stop) {
    std::unique_lock lock(mutex_);
    while (!stop.stop_requested()) {
        if (!changed_.wait(lock, stop, [this] { return !wanted_.empty(); })) return;
        const KernelKind what = *wanted_.begin();
        lock.unlock();
        build(what);
        lock.lock();
        wanted_.erase(what);
        changed_.notify_all();
    }
}

void OpenClPrograms::build(const KernelKind& what) {
    std::shared_ptr<OpenClBackend> backend;
    {
        const std::lock_guard lock(mutex_);
        backend = backend_;
    }
    bool opened = backend != nullptr;
    try {
        if (!opened) backend = std::make_shared<OpenClBackend>(*oracle_);
        opened = true;
        backend->build(what);
        const std::lock_guard lock(mutex_);
        backend_ = backend;
    } catch (const std::exception& error) {
        const std::lock_guard lock(mutex_);
        if (opened)
            failures_[what] = error.what();
        else
            device_reason_ = error.what();
    }
}

}  // namespace kiln
