// SPDX-License-Identifier: Apache-2.0
#include "server/http/connection.h"

#include <poll.h>
#include <sys/socket.h>
#include <sys/uio.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <vector>

#include "server/base/error.h"
#include "server/http/bounds.h"

namespace kiln {

namespace {

constexpr std::size_t kReadChunk = 4096;
constexpr std::size_t kBodyChunk = 256 * 1024;
constexpr std::chrono::milliseconds kIdleStep{100};

int milliseconds_until(std::chrono::steady_clock::time_point deadline) {
    const auto left =
        std::chrono::ceil<std::chrono::milliseconds>(deadline - std::chrono::steady_clock::now());
    return static_cast<int>(std::clamp<std::int64_t>(left.count(), 0, 1 << 30));
}

bool wait_for(int socket, short events, std::chrono::steady_clock::time_point deadline) {
    for (;;) {
        pollfd entry{socket, events, 0};
        const int ready = poll(&entry, 1, milliseconds_until(deadline));
        if (ready > 0) return true;
        if (ready == 0) return false;
        if (errno != EINTR) return false;
    }
}

/// Position after the empty line that ends the head, or npos. Throws on a line that ends with LF
/// alone and on too many lines, so that neither waits for its deadline.
std::size_t end_of_head(const std::string& input, std::size_t& scanned, std::size_t& lines) {
    while (true) {
        const std::size_t feed = input.find('\n', scanned);
        if (feed == input.npos) {
            scanned = input.size();
            return input.npos;
        }
        if (feed == 0 || input[feed - 1] != '\r')
            throw Error("bad_request", "a line of the request head does not end with CR LF");
        scanned = feed + 1;
        if (feed >= 3 && input.compare(feed - 3, 2, "\r\n") == 0) return scanned;
        if (++lines > kHeadLinesMax + 1)
            throw Error("headers_too_large",
                        "a request head has at most " + std::to_string(kHeadLinesMax) + " lines");
    }
}

}  // namespace

Connection::Connection(int socket, Limits limits) : socket_(socket), limits_(limits) {}

Connection::~Connection() {
    shutdown(socket_, SHUT_WR);
    // Unread bytes turn the close into a reset, which can overtake the answer. A client that is
    // still sending gets a bounded chance to finish and read why it was refused.
    std::array<char, kReadChunk> rest;
    const Clock::time_point deadline = Clock::now() + kLingerTimeMax;
    for (std::size_t taken = 0; taken < (lingers_ ? kLingerBytesMax : 16 * kReadChunk);) {
        if (lingers_ && !wait_readable(deadline)) break;
        const ssize_t got = recv(socket_, rest.data(), rest.size(), MSG_DONTWAIT);
        if (got <= 0) break;
        taken += static_cast<std::size_t>(got);
    }
    close(socket_);
}

bool Connection::wait_readable(Clock::time_point deadline) const {
    return wait_for(socket_, POLLIN, deadline);
}

bool Connection::receive(std::size_t size_max) {
    const std::size_t had = input_.size();
    input_.resize(had + std::min(size_max, kReadChunk));
    ssize_t got = 0;
    do {
        got = recv(socket_, input_.data() + had, input_.size() - had, MSG_DONTWAIT);
    } while (got < 0 && errno == EINTR);
    input_.resize(had + static_cast<std::size_t>(std::max<ssize_t>(got, 0)));
    return got > 0 || (got < 0 && (errno == EAGAIN || errno == EWOULDBLOCK));
}

Connection::Head Connection::read_head(std::string& head,
                                       const std::function<bool()>& give_up_idle) {
    const Clock::time_point idle_end = Clock::now() + (used_ ? limits_.idle : limits_.header);
    while (input_.empty()) {
        const auto step = std::min(idle_end, Clock::now() + kIdleStep);
        if (wait_readable(step)) {
            if (!receive(kReadChunk)) return Head::closed;
        } else if (Clock::now() >= idle_end || give_up_idle()) {
            return Head::closed;
        }
    }
    used_ = true;
    const Clock::time_point deadline = Clock::now() + limits_.header;
    std::size_t scanned = 0, lines = 0;
    for (;;) {
        // RFC 9112 2.2: an empty line before the request line is ignored.
        if (input_.compare(0, 2, "\r\n") == 0) {
            input_.erase(0, 2);
            scanned = lines = 0;
        }
        const std::size_t end = end_of_head(input_, scanned, lines);
        if (end != input_.npos && end <= kHeadBytesMax) {
            head.assign(input_, 0, end);
            input_.erase(0, end);
            return Head::complete;
        }
        if (end != input_.npos || input_.size() > kHeadBytesMax)
            throw Error("headers_too_large",
                        "a request head has at most " + std::to_string(kHeadBytesMax) + " bytes");
        if (!wait_readable(deadline)) return Head::timed_out;
        if (!receive(kReadChunk)) return Head::closed;
    }
}

bool Connection::read_body(std::uint64_t size, std::string& body) {
    const Clock::time_point deadline = Clock::now() + limits_.body;
    while (input_.size() < size) {
        if (!wait_readable(deadline)) return false;
        if (!receive(static_cast<std::size_t>(size) - input_.size())) return false;
    }
    body.assign(input_, 0, static_cast<std::size_t>(size));
    input_.erase(0, static_cast<std::size_t>(size));
    return true;
}

bool Connection::read_body(std::uint64_t size, const std::function<void(std::string_view)>& sink) {
    const Clock::time_point deadline =
        Clock::now() + limits_.body + std::chrono::seconds(size / kReceiveBytesPerSecondMin);
    const std::string first = input_.substr(0, static_cast<std::size_t>(size));
    input_.erase(0, first.size());
    if (!first.empty()) sink(first);
    std::uint64_t left = size - first.size();
    std::vector<char> piece(static_cast<std::size_t>(std::min<std::uint64_t>(left, kBodyChunk)));
    while (left > 0) {
        if (!wait_readable(deadline)) return false;
        const auto most = static_cast<std::size_t>(std::min<std::uint64_t>(left, piece.size()));
        const ssize_t got = recv(socket_, piece.data(), most, MSG_DONTWAIT);
        if (got < 0 && (errno == EINTR || errno == EAGAIN || errno == EWOULDBLOCK)) continue;
        if (got <= 0) return false;
        sink({piece.data(), static_cast<std::size_t>(got)});
        left -= static_cast<std::uint64_t>(got);
    }
    return true;
}

bool Connection::write(std::string_view bytes) {
    if (output_.size() + bytes.size() <= kCoalescedBytesMax) {
        output_ += bytes;
        return !failed_;
    }
    const bool sent = send_all(output_, bytes);
    output_.clear();
    return sent;
}

bool Connection::flush() {
    const bool sent = send_all(output_, {});
    output_.clear();
    return sent;
}

bool Connection::send_all(std::string_view first, std::string_view second) {
    const std::uint64_t size = first.size() + second.size();
    const Clock::time_point total_end =
        Clock::now() + limits_.send + std::chrono::seconds(size / kSendBytesPerSecondMin);
    while (!failed_ && (!first.empty() || !second.empty())) {
        std::array<iovec, 2> pieces{iovec{const_cast<char*>(first.data()), first.size()},
                                    iovec{const_cast<char*>(second.data()), second.size()}};
        msghdr message{};
        message.msg_iov = pieces.data();
        message.msg_iovlen = pieces.size();
        const ssize_t sent = sendmsg(socket_, &message, MSG_NOSIGNAL | MSG_DONTWAIT);
        if (sent >= 0) {
            const auto count = static_cast<std::size_t>(sent);
            const std::size_t from_first = std::min(count, first.size());
            first.remove_prefix(from_first);
            second.remove_prefix(count - from_first);
        } else if (errno == EAGAIN || errno == EWOULDBLOCK) {
            const auto deadline = std::min(total_end, Clock::now() + limits_.send);
            if (!wait_for(socket_, POLLOUT, deadline)) failed_ = true;
        } else if (errno != EINTR) {
            failed_ = true;
        }
    }
    return !failed_;
}

bool Connection::client_gone() const {
    pollfd entry{socket_, POLLRDHUP, 0};
    return poll(&entry, 1, 0) > 0;
}

}  // namespace kiln
