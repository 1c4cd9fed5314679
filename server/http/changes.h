// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <map>
#include <mutex>
#include <string>

namespace kiln {

/// Wakes whoever waits for a job. Only a hint: jobs also change by the hand of workers that cannot
/// ring here, so a watcher looks at the store in any case, at least every kLookInterval.
class Changes {
  public:
    static constexpr std::chrono::milliseconds kLookInterval{1000};
    enum class Interest { state, progress };

    void notify(const std::string& id, Interest what);
    /// Ends every wait, now and later.
    void close();
    bool closed();

  private:
    friend class Watch;
    struct Entry {
        int watchers = 0;
        std::uint64_t states = 0, progresses = 0;
    };
    std::mutex mutex_;
    std::condition_variable changed_;
    std::map<std::string, Entry> entries_;  ///< only of watched jobs
    bool closed_ = false;
};

/// One watcher of one job. Make it before looking at the store, so that no change falls between.
class Watch {
  public:
    Watch(Changes& changes, std::string id, Changes::Interest interest);
    ~Watch();
    Watch(const Watch&) = delete;
    Watch& operator=(const Watch&) = delete;
    /// Until a change since the last wait, `time` has passed, or the changes are closed.
    void wait(std::chrono::milliseconds time);

  private:
    std::uint64_t count() const;
    Changes& changes_;
    std::string id_;
    Changes::Interest interest_;
    std::uint64_t seen_ = 0;
};

}  // namespace kiln
