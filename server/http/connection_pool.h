// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace kiln {

/// Threads that serve connections, one each, started as they are needed. There are as many as
/// connections may be open, so that no accepted connection waits behind a slow one.
class ConnectionPool {
  public:
    explicit ConnectionPool(std::size_t threads_max) : threads_max_(threads_max) {}
    ~ConnectionPool() { stop(); }
    ConnectionPool(const ConnectionPool&) = delete;
    ConnectionPool& operator=(const ConnectionPool&) = delete;

    /// Opens a pool that was stopped.
    void start();
    /// False, and `task` is not taken, when every thread is busy.
    bool enqueue(const std::function<void()>& task);
    /// Returns when every task has ended.
    void stop();
    std::size_t busy();
    std::size_t threads_max() const { return threads_max_; }

  private:
    void serve();

    const std::size_t threads_max_;
    std::mutex mutex_;
    std::condition_variable wake_;
    std::deque<std::function<void()>> tasks_;
    std::vector<std::thread> threads_;
    std::size_t busy_ = 0;  ///< running or taken and waiting for its thread
    bool stopping_ = false;
};

}  // namespace kiln
