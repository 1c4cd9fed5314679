// SPDX-License-Identifier: Apache-2.0
#include "server/compute/thread_pool.h"

#include <sched.h>

#include <algorithm>
#include <utility>

namespace kiln {

namespace {
unsigned usable_cores() {
    cpu_set_t set;
    CPU_ZERO(&set);
    if (sched_getaffinity(0, sizeof(set), &set) != 0)
        return std::max(1u, std::thread::hardware_concurrency());
    return static_cast<unsigned>(std::max(1, CPU_COUNT(&set)));
}

/// A loop follows another within microseconds while a job runs, and waking a thread takes longer
/// than that: some 30 µs of waiting awake save it.
template <typename Condition>
void wait_awake(Condition done) {
    constexpr int kPauses = 600;
    for (int i = 0; i < kPauses && !done(); ++i) __builtin_ia32_pause();
}
}  // namespace

ThreadPool::ThreadPool(unsigned thread_count) {
    const unsigned total = thread_count == 0 ? usable_cores() : thread_count;
    shares_ = std::vector<Share>(total);
    for (unsigned i = 0; i + 1 < total; ++i) threads_.emplace_back([this, i] { work(i); });
}

ThreadPool::~ThreadPool() {
    {
        const std::lock_guard lock(mutex_);
        stop_ = true;
    }
    start_.notify_all();
}

void ThreadPool::drain(std::size_t self, const std::function<void(std::size_t)>& body) {
    try {
        for (std::size_t k = 0; k < shares_.size(); ++k) {
            Share& share = shares_[(self + k) % shares_.size()];
            for (std::size_t i;
                 (i = share.next.fetch_add(1, std::memory_order_relaxed)) < share.end;)
                body(i);
        }
    } catch (...) {
        const std::lock_guard lock(mutex_);
        if (!failure_) failure_ = std::current_exception();
        for (Share& share : shares_) share.next = share.end;
    }
}

void ThreadPool::parallel_for(std::size_t count, const std::function<void(std::size_t)>& body) {
    {
        const std::lock_guard lock(mutex_);
        body_ = &body;
        for (std::size_t k = 0; k < shares_.size(); ++k) {
            shares_[k].next = count * k / shares_.size();
            shares_[k].end = count * (k + 1) / shares_.size();
        }
        busy_ = static_cast<unsigned>(threads_.size());
        ++generation_;
    }
    start_.notify_all();
    drain(shares_.size() - 1, body);
    wait_awake([this] { return busy_ == 0; });
    std::unique_lock lock(mutex_);
    finished_.wait(lock, [this] { return busy_ == 0; });
    if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
}

void ThreadPool::work(std::size_t self) {
    std::size_t seen = 0;
    std::unique_lock lock(mutex_, std::defer_lock);
    for (;;) {
        wait_awake([&] { return stop_ || generation_ != seen; });
        lock.lock();
        start_.wait(lock, [&] { return stop_ || generation_ != seen; });
        if (stop_) return;
        seen = generation_;
        const auto* body = body_;
        lock.unlock();
        drain(self, *body);
        lock.lock();
        if (--busy_ == 0) finished_.notify_one();
        lock.unlock();
    }
}

}  // namespace kiln
