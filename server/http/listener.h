// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "server/http/connection.h"
#include "server/http/message.h"

namespace kiln {

struct ListenerOptions {
    std::size_t connections_max = 0;
    Connection::Limits timeouts{};
    /// Largest body for a path; a larger one gets 413 and is not read.
    std::function<std::uint64_t(const std::string& path)> body_bytes_max;
    /// Bodies for these paths go to their handler piece by piece (HttpRequest::receive).
    std::function<bool(const std::string& path)> streams_body = [](const std::string&) {
        return false;
    };
    /// Called once an answer, with its status, refused requests included.
    std::function<void(int status)> answered;
};

/// HTTP/1.1 on one TCP port: the only user of the HTTP library. The library accepts sockets and
/// writes answers; heads and bodies are read here, under bounds that the library does not have, and
/// it gets to see a head that was written from what was understood.
class Listener {
  public:
    Listener(ListenerOptions options, HttpHandler handler);
    ~Listener();

    /// Returns the port. Throws Error("cannot_listen") naming the address.
    int bind(const std::string& host, int port);
    /// Serves until stop(); returns when every connection has ended.
    void run();
    /// No new connections; open ones end after their current answer. Safe from any thread.
    void stop();
    std::size_t connections();

  private:
    class Server;
    std::unique_ptr<Server> server_;
};

}  // namespace kiln
