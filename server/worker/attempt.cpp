// SPDX-License-Identifier: Apache-2.0
#include "server/worker/attempt.h"

#include "server/base/error.h"
#include "server/base/log.h"

namespace kiln {

namespace {
/// Each renewal is a durable transaction; this bounds what it costs and how late a cancel is seen.
constexpr std::chrono::milliseconds kRenewInterval{100};
}  // namespace

Attempt::Attempt(JobStore& store, Mailbox& mailbox, const JobRecord& job,
                 std::chrono::milliseconds lease)
    : store_(store), mailbox_(mailbox), id_(job.id), number_(job.attempts), lease_(lease) {}

void Attempt::progress(const Progress& progress) {
    const bool rung = mailbox_.take_ring();
    const std::lock_guard lock(mutex_);
    told_ = told_ && progress.fraction == progress_.fraction;
    // The figures of the whole table are the ones that a finished job keeps.
    const bool last =
        progress.fraction >= 1 &&
        (progress_.fraction < 1 || progress.standard_error_max != progress_.standard_error_max);
    progress_ = progress;
    sign_ = Clock::now();
    renew_if_due(rung || last);
}

Attempt::State Attempt::look() {
    const bool rung = mailbox_.take_ring();
    const std::lock_guard lock(mutex_);
    if (state_ == State::running && mailbox_.stop() == Mailbox::Stop::drop_job)
        state_ = State::dropped;
    renew_if_due(rung);
    return state_;
}

Attempt::State Attempt::state() {
    const std::lock_guard lock(mutex_);
    return state_;
}

std::chrono::milliseconds Attempt::silence() {
    const std::lock_guard lock(mutex_);
    return std::chrono::duration_cast<std::chrono::milliseconds>(Clock::now() - sign_);
}

bool Attempt::integrated() {
    const std::lock_guard lock(mutex_);
    return progress_.fraction >= 1;
}

void Attempt::renew_if_due(bool rung) {
    if (state_ != State::running || (!rung && Clock::now() - renewed_ < kRenewInterval)) return;
    renewed_ = Clock::now();
    try {
        const Renewal renewal =
            store_.renew(id_, number_, lease_, progress_.fraction, progress_.standard_error_max);
        if (renewal == Renewal::lost) state_ = State::lost;
        if (renewal == Renewal::cancel_requested) {
            store_.cancelled(id_, number_);
            state_ = State::cancelled;
            mailbox_.say("state " + id_);
        }
    } catch (const Error& failure) {
        // The work goes on: the store may recover before the lease runs out, and fences us if not.
        log_line("renewal_failed", {{"job", id_}, {"detail", failure.what()}});
    }
    if (!told_) mailbox_.say("progress " + id_);
    told_ = true;
}

}  // namespace kiln
