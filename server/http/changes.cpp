// SPDX-License-Identifier: Apache-2.0
#include "server/http/changes.h"

namespace kiln {

void Changes::notify(const std::string& id, Interest what) {
    const std::lock_guard lock(mutex_);
    const auto found = entries_.find(id);
    if (found == entries_.end()) return;
    ++found->second.progresses;
    if (what == Interest::state) ++found->second.states;
    changed_.notify_all();
}

void Changes::close() {
    const std::lock_guard lock(mutex_);
    closed_ = true;
    changed_.notify_all();
}

bool Changes::closed() {
    const std::lock_guard lock(mutex_);
    return closed_;
}

Watch::Watch(Changes& changes, std::string id, Changes::Interest interest)
    : changes_(changes), id_(std::move(id)), interest_(interest) {
    const std::lock_guard lock(changes_.mutex_);
    ++changes_.entries_[id_].watchers;
    seen_ = count();
}

Watch::~Watch() {
    const std::lock_guard lock(changes_.mutex_);
    const auto found = changes_.entries_.find(id_);
    if (--found->second.watchers == 0) changes_.entries_.erase(found);
}

std::uint64_t Watch::count() const {
    const Changes::Entry& entry = changes_.entries_.at(id_);
    return interest_ == Changes::Interest::state ? entry.states : entry.progresses;
}

void Watch::wait(std::chrono::milliseconds time) {
    std::unique_lock lock(changes_.mutex_);
    changes_.changed_.wait_for(lock, time, [this] { return changes_.closed_ || count() != seen_; });
    seen_ = count();
}

}  // namespace kiln
