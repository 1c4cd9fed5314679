// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
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

    /// Until end() the attempt is watched.
    void begin(Attempt& attempt);
    /// Until end() a call into a driver is watched: one that reports no progress.
    void begin_call();
    void end();

  private:
    void run();
    [[noreturn]] static void end_process(std::chrono::milliseconds silence);

    Mailbox& mailbox_;
    const std::chrono::milliseconds stall_;
    std::mutex mutex_;
    std::condition_variable changed_;
    Attempt* attempt_ = nullptr;
    std::optional<std::chrono::steady_clock::time_point> called_;
    bool quit_ = false;
    std::thread thread_;
};

/// Watches an attempt, or one call, for as long as this lives.
class Watched {
  public:
    explicit Watched(Watchdog& watchdog) : watchdog_(watchdog) { watchdog.begin_call(); }
    Watched(Watchdog& watchdog, Attempt& attempt) : watchdog_(watchdog) { watchdog.begin(attempt); }
    ~Watched() { watchdog_.end(); }
    Watched(const Watched&) = delete;
    Watched& operator=(const Watched&) = delete;

  private:
    Watchdog& watchdog_;
};

}  // namespace kiln
