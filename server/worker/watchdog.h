// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "server/worker/attempt.h"
#include "server/worker/mailbox.h"

namespace kiln {

/// A thread beside the one that works. It tells the supervisor that the process lives, ends the
/// process when a device hangs (OpenCL has no way to stop a call that does not return), and keeps
/// the lease while a result is encoded and stored.
class Watchdog {
  public:
    Watchdog(Mailbox& mailbox, std::chrono::milliseconds stall);
    ~Watchdog();
    Watchdog(const Watchdog&) = delete;
    Watchdog& operator=(const Watchdog&) = delete;

    /// Between these two the attempt is watched.
    void begin(Attempt& attempt);
    void end();

  private:
    void run();

    Mailbox& mailbox_;
    const std::chrono::milliseconds stall_;
    std::mutex mutex_;
    std::condition_variable changed_;
    Attempt* attempt_ = nullptr;
    bool quit_ = false;
    std::thread thread_;
};

/// Watches an attempt for as long as this lives.
class Watched {
  public:
    Watched(Watchdog& watchdog, Attempt& attempt) : watchdog_(watchdog) { watchdog.begin(attempt); }
    ~Watched() { watchdog_.end(); }
    Watched(const Watched&) = delete;
    Watched& operator=(const Watched&) = delete;

  private:
    Watchdog& watchdog_;
};

}  // namespace kiln
