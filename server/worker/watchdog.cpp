// SPDX-License-Identifier: Apache-2.0
#include "server/worker/watchdog.h"

#include <unistd.h>

#include "server/base/exit_status.h"
#include "server/base/log.h"
#include "server/worker/bounds.h"

namespace kiln {

namespace {
constexpr std::chrono::milliseconds kTick{100};
constexpr std::chrono::milliseconds kSignOfLife{500};
}  // namespace

Watchdog::Watchdog(Mailbox& mailbox, std::chrono::milliseconds stall)
    : mailbox_(mailbox), stall_(stall), thread_([this] { run(); }) {}

Watchdog::~Watchdog() {
    {
        const std::lock_guard lock(mutex_);
        quit_ = true;
    }
    changed_.notify_all();
    thread_.join();
}

void Watchdog::begin(Attempt& attempt) {
    const std::lock_guard lock(mutex_);
    attempt_ = &attempt;
}

void Watchdog::begin_call() {
    const std::lock_guard lock(mutex_);
    called_ = std::chrono::steady_clock::now();
}

void Watchdog::end() {
    const std::lock_guard lock(mutex_);
    attempt_ = nullptr;
    called_.reset();
}

void Watchdog::end_process(std::chrono::milliseconds silence) {
    log_line("hung", {{"silence_ms", std::to_string(silence.count())}});
    _exit(kExitHung);
}

void Watchdog::run() {
    using Clock = std::chrono::steady_clock;
    Clock::time_point told{};
    std::unique_lock lock(mutex_);
    while (!quit_) {
        if (Clock::now() - told >= kSignOfLife) {
            mailbox_.say("alive");
            told = Clock::now();
        }
        if (attempt_ != nullptr) {
            const bool storing = attempt_->integrated();
            const std::chrono::milliseconds silence = attempt_->silence();
            if (silence > (storing ? std::chrono::milliseconds(kStoringTimeMax) : stall_))
                end_process(silence);
            if (storing) attempt_->look();
        }
        if (called_ && Clock::now() - *called_ > stall_)
            end_process(
                std::chrono::duration_cast<std::chrono::milliseconds>(Clock::now() - *called_));
        changed_.wait_for(lock, kTick);
    }
}

}  // namespace kiln
