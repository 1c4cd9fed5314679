// SPDX-License-Identifier: Apache-2.0
#include "client/interrupt.h"

#include <pthread.h>
#include <unistd.h>

#include <cstdio>

namespace kiln::client {

namespace {

constexpr int kWake = SIGUSR1;  // sent by the destructor alone, to end the listener
constexpr timespec kPatience{.tv_sec = 5, .tv_nsec = 0};

sigset_t watched() {
    sigset_t set;
    sigemptyset(&set);
    for (int number : {SIGINT, SIGTERM, SIGHUP, kWake}) sigaddset(&set, number);
    return set;
}

}  // namespace

Interrupt::Interrupt() {
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
    const sigset_t set = watched();
    int number = 0;
    sigwait(&set, &number);
    if (leaving_) return;
    requested_ = true;
    sigtimedwait(&set, nullptr, &kPatience);
    if (!leaving_) _exit(static_cast<int>(Exit::interrupted));
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
                  "not done within " + std::string(seconds) + " s; the job was cancelled");
}

}  // namespace kiln::client
