// SPDX-License-Identifier: Apache-2.0
#include "server/worker/mailbox.h"

#include <poll.h>
#include <sys/eventfd.h>
#include <sys/signalfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <string>
#include <utility>

#include "server/base/error.h"

namespace kiln {

Mailbox::Mailbox(int socket) : socket_(socket) {
    sigset_t ends;
    sigemptyset(&ends);
    sigaddset(&ends, SIGTERM);
    sigaddset(&ends, SIGINT);
    signals_ = signalfd(-1, &ends, SFD_CLOEXEC | SFD_NONBLOCK);
    quit_ = eventfd(0, EFD_CLOEXEC);
    if (signals_ < 0 || quit_ < 0) throw Error("cannot_start", "signalfd or eventfd failed");
    thread_ = std::thread([this] { listen(); });
}

Mailbox::~Mailbox() {
    const std::uint64_t one = 1;
    [[maybe_unused]] const ssize_t written = write(quit_, &one, sizeof one);
    thread_.join();
    close(signals_);
    close(quit_);
}

void Mailbox::wait(std::chrono::milliseconds time) {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, time, [this] { return rung_ || stop_ != Stop::none; });
    rung_ = false;
}

bool Mailbox::take_ring() {
    const std::lock_guard lock(mutex_);
    return std::exchange(rung_, false);
}

Mailbox::Stop Mailbox::stop() {
    const std::lock_guard lock(mutex_);
    return stop_;
}

void Mailbox::say(std::string_view line) {
    if (socket_ < 0) return;
    const std::string text = std::string(line) + '\n';
    // A short write would tear a line in two, so lines are sent whole or, when the socket is full,
    // not at all; the supervisor reads all the time.
    const std::lock_guard lock(saying_);
    send(socket_, text.data(), text.size(), MSG_NOSIGNAL | (text.size() < 1024 ? MSG_DONTWAIT : 0));
}

void Mailbox::listen() {
    for (;;) {
        std::array<pollfd, 3> entries{pollfd{quit_, POLLIN, 0}, pollfd{signals_, POLLIN, 0},
                                      pollfd{socket_, POLLIN, 0}};  // poll skips a negative one
        if (poll(entries.data(), entries.size(), -1) < 0 && errno != EINTR) return;
        if (entries[0].revents != 0) return;
        signalfd_siginfo info{};
        while (read(signals_, &info, sizeof info) == sizeof info) {
            // Ctrl-C reaches the whole group; the supervisor then decides for its workers.
            if (info.ssi_signo == SIGTERM || socket_ < 0) raise_stop(false);
        }
        if (entries[2].revents != 0 && !read_socket()) {
            socket_ = -1;
            raise_stop(true);
        }
    }
}

bool Mailbox::read_socket() {
    std::array<char, 64> bytes;
    const ssize_t got = recv(socket_, bytes.data(), bytes.size(), MSG_DONTWAIT);
    if (got == 0 || (got < 0 && errno != EAGAIN && errno != EINTR)) return false;
    const std::lock_guard lock(mutex_);
    rung_ = true;
    changed_.notify_all();
    return true;
}

void Mailbox::raise_stop(bool supervisor_gone) {
    const std::lock_guard lock(mutex_);
    stop_ = supervisor_gone || stop_ != Stop::none ? Stop::drop_job : Stop::finish_job;
    changed_.notify_all();
}

}  // namespace kiln
