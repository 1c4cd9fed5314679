// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <signal.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "client/failure.h"

namespace kiln::client {

/// Takes SIGINT, SIGTERM and SIGHUP for as long as it lives, so that a bake may cancel its job and
/// leave in order. Make it before any other thread: threads inherit the blocked signals. Where a
/// driver does not come back within five seconds of the signal or of the time limit, and at a
/// second signal, it ends the process with the exit status that was due.
class Interrupt {
  public:
    /// timeout_s: 0 = no limit.
    explicit Interrupt(double timeout_s);
    ~Interrupt();
    Interrupt(const Interrupt&) = delete;
    Interrupt& operator=(const Interrupt&) = delete;
    bool requested() const { return requested_; }

  private:
    void listen();
    double timeout_s_;
    std::atomic<bool> requested_{false};
    std::atomic<bool> leaving_{false};
    sigset_t before_{};
    std::thread listener_;
};

/// Why a bake must stop before it is done, if it must.
class Stop {
  public:
    /// timeout_s: 0 = no limit.
    Stop(const Interrupt& interrupt, double timeout_s);
    bool requested() const { return interrupt_.requested() || late(); }
    /// Throws Failure(interrupted or timed_out). Call once requested() is true.
    [[noreturn]] void leave() const;

  private:
    bool late() const;
    const Interrupt& interrupt_;
    double timeout_s_;
    std::chrono::steady_clock::time_point start_;
};

}  // namespace kiln::client
