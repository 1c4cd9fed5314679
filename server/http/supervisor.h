// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <atomic>
#include <chrono>
#include <deque>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "server/http/changes.h"
#include "server/http/child_process.h"
#include "server/http/metrics.h"
#include "server/http/service.h"
#include "server/settings/settings.h"
#include "server/store/job_store.h"

namespace kiln {

/// Keeps the worker processes of this host alive: starts them, wakes them, hears from them, kills
/// the silent, returns the jobs of the dead to the queue and starts successors. After too many
/// deaths in a row the successors leave OpenCL alone for a while.
class Supervisor {
  public:
    Supervisor(const Settings& settings, JobStore& store, Changes& changes, Metrics& metrics);
    ~Supervisor();
    Supervisor(const Supervisor&) = delete;
    Supervisor& operator=(const Supervisor&) = delete;

    /// Takes over the jobs of workers that an earlier run of this server left behind, then starts
    /// its own.
    void start();
    /// Tells every worker to look into the store.
    void ring();
    std::vector<WorkerStatus> workers();

    /// Workers finish what they run within drain_s and end; hurry() makes them drop it.
    void begin_stop();
    void hurry() { hurried_ = true; }
    bool stopped() const { return stopped_; }

  private:
    using Clock = std::chrono::steady_clock;
    struct Slot {
        std::string name, cache_dir;
        ChildProcess child;
        std::string input;  ///< of the worker, up to its next line end
        std::string devices_json;
        std::string end_reason;    ///< why it was killed, when this process did that
        std::string release_note;  ///< not yet given to the store
        bool release_due = false;
        Clock::time_point heard, started, restart_at;
        std::chrono::milliseconds backoff{0};
        bool started_before = false;
    };

    void run();
    void wait_for_events();
    void ring_all();
    void start_worker(Slot& slot);
    std::vector<std::string> arguments_for(const Slot& slot) const;
    void listen_to(Slot& slot);
    void take_line(Slot& slot, std::string_view line);
    void kill_if_silent(Slot& slot);
    void reap(Slot& slot);
    void buried(Slot& slot, int status);
    void release(Slot& slot);
    void note_death();
    void push_to_end();
    bool any_alive() const;
    void wake();

    const Settings& settings_;
    JobStore& store_;
    Changes& changes_;
    Metrics& metrics_;
    std::mutex mutex_;  ///< guards what workers() reads of the slots
    std::vector<Slot> slots_;
    std::deque<Clock::time_point> deaths_;
    Clock::time_point opencl_off_until_{};
    std::string opencl_off_reason_;
    int wake_fd_ = -1;
    std::atomic<bool> ring_due_{false}, stopping_{false}, hurried_{false}, stopped_{false};
    Clock::time_point stop_began_{};
    int stop_signals_ = 0;
    std::thread thread_;
};

}  // namespace kiln
