// SPDX-License-Identifier: Apache-2.0
#include "server/http/connection_pool.h"

namespace kiln {

void ConnectionPool::start() {
    const std::lock_guard lock(mutex_);
    stopping_ = false;
}

bool ConnectionPool::enqueue(const std::function<void()>& task) {
    const std::lock_guard lock(mutex_);
    if (stopping_ || busy_ == threads_max_) return false;
    ++busy_;
    tasks_.push_back(task);
    if (threads_.size() < busy_) threads_.emplace_back([this] { serve(); });
    wake_.notify_one();
    return true;
}

void ConnectionPool::serve() {
    std::unique_lock lock(mutex_);
    for (;;) {
        wake_.wait(lock, [this] { return stopping_ || !tasks_.empty(); });
        if (tasks_.empty()) return;
        const std::function<void()> task = std::move(tasks_.front());
        tasks_.pop_front();
        lock.unlock();
        task();
        lock.lock();
        --busy_;
    }
}

void ConnectionPool::stop() {
    {
        const std::lock_guard lock(mutex_);
        stopping_ = true;
    }
    wake_.notify_all();
    for (std::thread& thread : threads_) thread.join();
    threads_.clear();
}

std::size_t ConnectionPool::busy() {
    const std::lock_guard lock(mutex_);
    return busy_;
}

}  // namespace kiln
