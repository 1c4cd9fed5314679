// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace kiln {

/// Threads that share the indices of one loop at a time. The calling thread works too. A thread
/// first takes its own share of the indices, the same in each loop of one length, so that what one
/// loop leaves in a core's cache the next one finds there; then it helps the others.
class ThreadPool {
  public:
    /// thread_count 0: one a core that this process may use.
    explicit ThreadPool(unsigned thread_count);
    ~ThreadPool();

    unsigned size() const { return static_cast<unsigned>(threads_.size()) + 1; }
    /// Calls body(i) once for each i in [0, count), in any order on any thread, and returns when
    /// all are done. Throws the first thing that body throws, when no thread is in it any more;
    /// what was not begun by then is left out.
    void parallel_for(std::size_t count, const std::function<void(std::size_t)>& body);

  private:
    struct alignas(64) Share {
        std::atomic<std::size_t> next{0};
        std::size_t end = 0;
    };
    void work(std::size_t self);
    void drain(std::size_t self, const std::function<void(std::size_t)>& body);

    std::mutex mutex_;
    std::condition_variable start_, finished_;
    const std::function<void(std::size_t)>* body_ = nullptr;
    std::exception_ptr failure_;              // under the mutex
    std::vector<Share> shares_;               // one a thread; the calling thread's is the last
    std::atomic<std::size_t> generation_{0};  // written under the mutex, as are the next two
    std::atomic<unsigned> busy_{0};
    std::atomic<bool> stop_{false};
    std::vector<std::jthread> threads_;
};

}  // namespace kiln
