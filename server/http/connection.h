// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

namespace kiln {

/// One accepted socket under absolute deadlines. Nothing that a client sends or withholds makes it
/// hold more than a request head and one body of the agreed size, or wait longer than its limits
/// say.
class Connection {
  public:
    struct Limits {
        std::chrono::milliseconds header, idle, body, send;
    };
    enum class Head { complete, closed, timed_out };

    /// Takes the socket over and closes it in the end.
    Connection(int socket, Limits limits);
    ~Connection();
    Connection(const Connection&) = delete;
    Connection& operator=(const Connection&) = delete;

    /// Waits for the next head, ending with its empty line. `idle` may end the wait for the first
    /// byte early: it is asked every 100 ms. Throws Error("headers_too_large" | "bad_request").
    Head read_head(std::string& head, const std::function<bool()>& give_up_idle);
    /// False when the client closed or was too slow.
    bool read_body(std::uint64_t size, std::string& body);
    /// The same, piece by piece. A large body has more time: what it takes at
    /// kReceiveBytesPerSecondMin. What the sink throws ends the reading.
    bool read_body(std::uint64_t size, const std::function<void(std::string_view)>& sink);
    /// Small pieces wait for the next large one or flush(). False once the client takes no more.
    bool write(std::string_view bytes);
    bool flush();
    bool client_gone() const;
    /// What the client still sends was refused: it is read and dropped for a moment at the end.
    void linger() { lingers_ = true; }
    bool failed() const { return failed_; }

  private:
    using Clock = std::chrono::steady_clock;
    bool wait_readable(Clock::time_point deadline) const;
    /// Appends what is there to input_; false when the client has closed.
    bool receive(std::size_t size_max);
    bool send_all(std::string_view first, std::string_view second);

    int socket_;
    Limits limits_;
    std::string input_;   ///< received, not yet consumed
    std::string output_;  ///< written, not yet sent
    bool used_ = false;   ///< a request was read
    bool failed_ = false;
    bool lingers_ = false;
};

}  // namespace kiln
