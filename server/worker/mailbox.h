// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <string_view>
#include <thread>

namespace kiln {

/// What reaches a worker from outside: the supervisor's rings, its end, and SIGTERM or SIGINT,
/// which must be blocked in every thread before this is made.
class Mailbox {
  public:
    enum class Stop { none, finish_job, drop_job };

    /// `socket` to the supervisor, -1 when there is none.
    explicit Mailbox(int socket);
    ~Mailbox();
    Mailbox(const Mailbox&) = delete;
    Mailbox& operator=(const Mailbox&) = delete;

    /// Until a ring, a stop, or `time` has passed.
    void wait(std::chrono::milliseconds time);
    /// True once after each ring.
    bool take_ring();
    Stop stop();
    /// One line to the supervisor. It is lost rather than waited for when nobody reads.
    void say(std::string_view line);

  private:
    void listen();
    /// False when the supervisor is gone.
    bool read_socket();
    void raise_stop(bool supervisor_gone);

    std::atomic<int> socket_;
    int signals_, quit_;
    std::mutex mutex_, saying_;
    std::condition_variable changed_;
    bool rung_ = false;
    Stop stop_ = Stop::none;
    std::thread thread_;
};

}  // namespace kiln
