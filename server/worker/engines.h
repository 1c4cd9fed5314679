// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>
#include <memory>
#include <string>

#include "server/compute/engine.h"
#include "server/settings/settings.h"

namespace kiln {

/// The engine of a worker, and the one beside it that leaves OpenCL alone: for a job whose last
/// worker died, and for everything while the supervisor has switched OpenCL off.
class Engines {
  public:
    explicit Engines(const Settings& settings);
    /// `note` says why an earlier attempt at the job ended, "" when there was none.
    Engine& pick(const std::string& note);
    /// Tries OpenCL again once the supervisor's time has run out.
    void refresh();

  private:
    using Clock = std::chrono::steady_clock;
    std::unique_ptr<Engine> make(const std::string& opencl_disabled_reason) const;

    const Settings& settings_;
    Clock::time_point opencl_off_until_;
    std::unique_ptr<Engine> usual_;
    std::unique_ptr<Engine> careful_;
    bool opencl_off_ = false;
};

}  // namespace kiln
