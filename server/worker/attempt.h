// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>
#include <mutex>
#include <string>

#include "server/compute/engine.h"
#include "server/store/job_store.h"
#include "server/worker/mailbox.h"

namespace kiln {

/// One claimed job while it runs: renews the lease, passes progress on, and learns whether to go
/// on. Safe from any thread.
class Attempt {
  public:
    enum class State {
        running,
        cancelled,  ///< the client asked; the store knows
        lost,       ///< another worker has the job
        dropped,    ///< this worker is to end
    };

    Attempt(JobStore& store, Mailbox& mailbox, const JobRecord& job,
            std::chrono::milliseconds lease);

    /// Notes the progress and renews the lease when that is due.
    void progress(const Progress& progress);
    /// Renews when that is due or the supervisor rang.
    State look();
    State state();
    /// Time since the engine last gave a sign.
    std::chrono::milliseconds silence();
    /// The integration is over: what follows, encoding and storing, gives no signs.
    bool integrated();

  private:
    using Clock = std::chrono::steady_clock;
    void renew_if_due(bool rung);

    JobStore& store_;
    Mailbox& mailbox_;
    const std::string id_;
    const int number_;
    const std::chrono::milliseconds lease_;
    std::mutex mutex_;
    Progress progress_;
    bool told_ = true;
    Clock::time_point renewed_ = Clock::now(), sign_ = renewed_;
    State state_ = State::running;
};

}  // namespace kiln
