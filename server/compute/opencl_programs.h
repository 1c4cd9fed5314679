// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>
#include <condition_variable>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <thread>

#include "server/compute/opencl.h"
#include "server/compute/thread_pool.h"

namespace kiln {

/// A device that failed this often is not opened again: every try costs its job a restart on
/// native.
inline constexpr int kDeviceFailuresMax = 3;

/// Opens the OpenCL device and builds its programs on a thread of its own, so that the first jobs
/// need not wait for a compiler.
class OpenClPrograms {
  public:
    OpenClPrograms();
    ~OpenClPrograms();

    /// Asks for a program; returns at once.
    void request(const KernelKind& what);

    struct Answer {
        std::shared_ptr<OpenClBackend> backend;  ///< null unless the program is built
        std::string reason;                      ///< why it is null
        bool pending = false;                    ///< still being built
    };
    Answer look(const KernelKind& what);
    /// Waits until look() is no longer pending, or until `keep_waiting` (asked every 50 ms) says
    /// no.
    Answer wait(const KernelKind& what, const std::function<bool()>& keep_waiting);

    /// A launch failed: the device is opened afresh for later jobs, a few times.
    void device_failed(const std::string& reason);

  private:
    void work(const std::stop_token& stop);
    void build(const KernelKind& what);
    Answer look_locked(const KernelKind& what) const;

    ThreadPool trial_pool_{1};
    std::unique_ptr<Backend> oracle_;
    std::mutex mutex_;
    std::condition_variable_any changed_;
    std::shared_ptr<OpenClBackend> backend_;
    std::string device_reason_;                   // not empty: the device cannot be opened
    std::map<KernelKind, std::string> failures_;  // programs that cannot be built
    std::set<KernelKind> wanted_;
    int device_failures_ = 0;
    std::jthread thread_;
};

}  // namespace kiln
