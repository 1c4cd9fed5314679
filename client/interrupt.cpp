// SPDX-License-Identifier: Apache-2.0
#include "client/interrupt.h"

#include <pthread.h>
#include <unistd.h>

#include <cstdio>

namespace kiln::client {

namespace {

constexpr int kWake = SIGUSR1;  // sent by the destructor alone, to end the listener
constexpr std::chrono::seconds kPatience{5};
using Clock = std::chrono::steady_clock;

sigset_t watched() {
    sigset_t set;
    sigemptyset(&set);
    for (int number : {SIGINT, SIGTERM, SIGHUP, kWake}) sigaddset(&set, number);
    return set;
}

/// False once `deadline` has passed without a signal.
bool signal_before(Clock::time_point deadline) {
    const sigset_t set = watched();
    // In short turns: a process that was stopped and goes on returns early from any of them.
    while (Clock::now() < deadline) {
        const timespec turn{.tv_sec = 0, .tv_nsec = 200'000'000};
        if (sigtimedwait(&set, nullptr, &turn) > 0) return true;
    }
    return false;
}

[[noreturn]] void end_now(Exit exit) {
    static constexpr char kMessage[] = "kiln: the device does not come back; left without it\n";
    [[maybe_unused]] const auto written = ::write(STDERR_FILENO, kMessage, sizeof kMessage - 1);
    _exit(static_cast<int>(exit));
}

}  // namespace

Interrupt::Interrupt(double timeout_s) : timeout_s_(timeout_s) {
    const sigset_t set = watched();
    pthread_sigmask(SIG_BLOCK, &set, &before_);
    listener_ = std::thread([this] { listen(); });
}

Interrupt::~Interrupt() {
    leaving_ = true;
    pthread_kill(listener_.native_handle(), kWake);
    listener_.join();
    pthread_sigmask(SIG_SETMASK, &before_, nullptr);
}

void Interrupt::listen() {
    // A year stands for no limit.
    const std::chrono::duration<double> limit(timeout_s_ > 0 ? timeout_s_ : 3e7);
    const auto deadline =
        Clock::now() + std::chrono::duration_cast<Clock::duration>(limit) + kPatience;
    const bool interrupted = signal_before(deadline);
    if (leaving_) return;
    if (!interrupted) end_now(Exit::timed_out);
    requested_ = true;
    signal_before(Clock::now() + kPatience);
    if (!leaving_) end_now(Exit::interrupted);
}

Stop::Stop(const Interrupt& interrupt, double timeout_s)
    : interrupt_(interrupt), timeout_s_(timeout_s), start_(std::chrono::steady_clock::now()) {}

bool Stop::late() const {
    if (timeout_s_ <= 0) return false;
    return std::chrono::steady_clock::now() - start_ > std::chrono::duration<double>(timeout_s_);
}

void Stop::leave() const {
    if (interrupt_.requested())
        throw Failure(Exit::interrupted, "interrupted", "interrupted; nothing was written");
    char seconds[32];
    std::snprintf(seconds, sizeof seconds, "%g", timeout_s_);
    throw Failure(Exit::timed_out, "timed_out",
                  "not done within " + std::string(seconds) + " s; nothing was written");
}

}  // namespace kiln::client
