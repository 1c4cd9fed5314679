// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace kiln {

/// Threads that share the indices of one loop at a time. The calling thread works too.
class ThreadPool {
  public:
    /// thread_count 0: one a core that this process may use.
    explicit ThreadPool(unsigned thread_count);
    ~ThreadPool();

    unsigned size() const { return static_cast<unsigned>(threads_.size()) + 1; }
    /// Calls body(i) once for each i in [0, count), in any order on any thread, and returns when
    /// all are done. body must not throw.
    void parallel_for(std::size_t count, const std::function<void(std::size_t)>& body);

  private:
    void work();
    void drain(const std::function<void(std::size_t)>& body);

    std::mutex mutex_;
    std::condition_variable start_, finished_;
    const std::function<void(std::size_t)>* body_ = nullptr;
    std::size_t count_ = 0;
    std::atomic<std::size_t> next_{0};
    std::atomic<std::size_t> generation_{0};  // written under the mutex, as are the next two
    std::atomic<unsigned> busy_{0};
    std::atomic<bool> stop_{false};
    std::vector<std::jthread> threads_;
};

}  // namespace kiln
