// SPDX-License-Identifier: Apache-2.0
#include "server/http/listener.h"

#include <httplib.h>
#include <sys/socket.h>

#include <atomic>
#include <cstring>
#include <mutex>

#include "server/base/error.h"
#include "server/base/log.h"
#include "server/http/bounds.h"
#include "server/http/connection_pool.h"
#include "server/http/problems.h"
#include "server/http/request_head.h"
#include "server/spec/limits.h"

namespace kiln {

namespace {

/// From this share of the connections on, idle ones make room.
constexpr double kPressure = 0.75;

/// What the library reads is `head`; what it writes goes to the connection.
class GuardedStream final : public httplib::Stream {
  public:
    GuardedStream(Connection& connection, std::string head)
        : connection_(connection), head_(std::move(head)) {}

    bool is_readable() const override { return read_ < head_.size(); }
    bool is_writable() const override { return !connection_.failed(); }
    ssize_t read(char* to, std::size_t size) override {
        const std::size_t count = std::min(size, head_.size() - read_);
        std::memcpy(to, head_.data() + read_, count);
        read_ += count;
        return static_cast<ssize_t>(count);
    }
    ssize_t write(const char* from, std::size_t size) override {
        return connection_.write({from, size}) ? static_cast<ssize_t>(size) : -1;
    }
    // Addresses are no part of any answer or decision.
    void get_remote_ip_and_port(std::string&, int&) const override {}
    void get_local_ip_and_port(std::string&, int&) const override {}
    socket_t socket() const override { return INVALID_SOCKET; }

  private:
    Connection& connection_;
    std::string head_;
    std::size_t read_ = 0;
};

/// The answer that the library is to write next on this thread.
thread_local HttpResponse* pending = nullptr;
/// Set while the accepting thread turns a connection away.
thread_local bool turning_away = false;

httplib::Server::HandlerResponse fill(const httplib::Request&, httplib::Response& to) {
    HttpResponse& from = *pending;
    to.status = from.status;
    for (const auto& [name, value] : from.headers) to.set_header(name, value);
    if (!from.content_type.empty()) to.set_header("Content-Type", from.content_type);
    if (from.blob)
        to.set_header("Content-Length", std::to_string(from.length));
    else if (!from.stream)
        to.body = from.body;
    return httplib::Server::HandlerResponse::Handled;
}

/// Takes back what the library says on its own and the answer does not mean.
void correct(const httplib::Request&, httplib::Response& response) {
    response.headers.erase("Keep-Alive");
    if (pending->stream || response.status == 304) response.headers.erase("Content-Length");
}

/// The part of a request in the memory that large bodies share.
class Upload {
  public:
    explicit Upload(std::atomic<std::uint64_t>& total) : total_(total) {}
    ~Upload() { total_ -= bytes_; }
    Upload(const Upload&) = delete;
    Upload& operator=(const Upload&) = delete;
    bool take(std::uint64_t bytes) {
        if (bytes <= static_cast<std::uint64_t>(limits().batch_bytes_max)) return true;
        bytes_ = bytes;
        return (total_ += bytes) <= kUploadBytesMax;
    }

  private:
    std::atomic<std::uint64_t>& total_;
    std::uint64_t bytes_ = 0;
};

/// Gives the library's accepted sockets to the pool.
class PoolQueue final : public httplib::TaskQueue {
  public:
    explicit PoolQueue(ConnectionPool& pool) : pool_(pool) { pool_.start(); }
    void enqueue(std::function<void()> task) override {
        if (pool_.enqueue(task)) return;
        turning_away = true;
        task();
        turning_away = false;
    }
    void shutdown() override { pool_.stop(); }

  private:
    ConnectionPool& pool_;
};

}  // namespace

class Listener::Server final : public httplib::Server {
  public:
    Server(ListenerOptions options, HttpHandler handler)
        : options_(std::move(options)),
          handler_(std::move(handler)),
          pool_(options_.connections_max) {
        new_task_queue = [this] { return new PoolQueue(pool_); };
        set_tcp_nodelay(true);
        // The library's own options set SO_REUSEPORT: two servers would share a port unnoticed.
        set_socket_options([this](socket_t socket) {
            const int on = 1;
            setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
            listening_socket_ = socket;
        });
        set_pre_routing_handler(fill);
        set_post_routing_handler(correct);
        // Without a handler of one's own the library sends the text of exceptions in a header.
        set_exception_handler([](const httplib::Request&, httplib::Response& response,
                                 const std::exception_ptr&) { response.status = 500; });
    }

    int bind_and_listen(const std::string& host, int port) {
        port_ = port;
        const bool bound =
            port != 0 ? bind_to_port(host, port) : (port_ = bind_to_any_port(host)) > 0;
        if (!bound || ::listen(listening_socket_, kBacklogMax) != 0)
            throw kiln::Error("cannot_listen", "cannot listen on " + host + " port " +
                                                   std::to_string(port) + ": " +
                                                   std::strerror(errno));
        host_ = host;
        return port_;
    }

    void run() {
        while (!stopping_) {
            listen_after_bind();
            if (stopping_) return;
            // The library gives up on any error of accept() that it does not know.
            log_line("accept_failed", {{"detail", std::strerror(errno)}});
            bind_and_listen(host_, port_);
        }
    }

    void stop_soon() {
        stopping_ = true;
        stop();
    }

    std::size_t connections() { return pool_.busy(); }

  private:
    bool process_and_close_socket(socket_t socket) override {
        Connection connection(socket, options_.timeouts);
        if (turning_away) {
            HttpResponse response = problem("too_many_connections", "every connection is in use");
            deliver(connection, "GET", response, true);
            return false;
        }
        try {
            while (serve_one(connection)) continue;
        } catch (const std::exception& failure) {  // bad_alloc and the like: this connection ends
            log_line("connection_failed", {{"detail", failure.what()}});
        }
        return true;
    }

    /// One request and its answer; false when the connection is to end.
    bool serve_one(Connection& connection) {
        std::string text;
        RequestHead head;
        HttpResponse response;
        Upload upload(upload_bytes_);
        bool closes = true;
        try {
            const auto read = connection.read_head(text, [this] {
                return stopping_ || static_cast<double>(pool_.busy()) >
                                        kPressure * static_cast<double>(pool_.threads_max());
            });
            if (read == Connection::Head::closed) return false;
            if (read == Connection::Head::timed_out)
                throw kiln::Error("timeout", "the request head did not come in time");
            head = parse_head(text);
            head.request.client_gone = [&connection] { return connection.client_gone(); };
            bool body_taken = take_body(connection, head, upload);
            if (head.request.receive)
                head.request.receive = [&](const BodySink& sink) {
                    stream_body(connection, head, sink);
                    body_taken = true;
                };
            response = answer(head.request);
            if (!body_taken) connection.linger();
            closes = !body_taken || !head.request.keep_alive || stopping_;
        } catch (const kiln::Error& refusal) {
            response = problem_of(refusal);
            connection.linger();
        }
        closes = closes || static_cast<bool>(response.stream);
        return deliver(connection, head.request.method, response, closes) && !closes;
    }

    static void stream_body(Connection& connection, const RequestHead& head, const BodySink& sink) {
        if (head.expects_continue) {
            connection.write("HTTP/1.1 100 Continue\r\n\r\n");
            connection.flush();
        }
        if (!connection.read_body(head.content_length, sink))
            throw kiln::Error("timeout", "the request body did not come in time");
    }

    /// False when the body was left unread: nothing at this path takes one, or its handler does.
    bool take_body(Connection& connection, RequestHead& head, Upload& upload) const {
        head.request.content_length = head.content_length;
        const bool streams =
            head.request.method == "POST" && options_.streams_body(head.request.path);
        if (streams) head.request.receive = [](const BodySink&) {};
        if (head.content_length == 0) return true;
        const std::uint64_t bytes_max =
            head.request.method == "POST" ? options_.body_bytes_max(head.request.path) : 0;
        if (bytes_max == 0) return false;
        if (head.content_length > bytes_max)
            throw kiln::Error("too_large", "the body has " + std::to_string(head.content_length) +
                                               " bytes; at most " + std::to_string(bytes_max) +
                                               " are taken here");
        if (streams) return false;
        if (!upload.take(head.content_length))
            throw kiln::Error("too_many_uploads",
                              "the server holds as many large bodies as it may; try again soon");
        if (head.expects_continue) {
            connection.write("HTTP/1.1 100 Continue\r\n\r\n");
            if (!connection.flush()) return false;
        }
        if (!connection.read_body(head.content_length, head.request.body))
            throw kiln::Error("timeout", "the request body did not come in time");
        return true;
    }

    HttpResponse answer(const HttpRequest& request) const {
        try {
            return handler_(request);
        } catch (const std::exception& failure) {
            return problem_of(failure);
        }
    }

    bool deliver(Connection& connection, const std::string& method, HttpResponse& response,
                 bool closes) {
        const bool head_only = method == "HEAD";
        GuardedStream stream(connection,
                             head_only ? "HEAD / HTTP/1.1\r\n\r\n" : "GET / HTTP/1.1\r\n\r\n");
        bool library_closes = false;
        pending = &response;
        bool delivered = process_request(stream, closes, library_closes, nullptr);
        pending = nullptr;
        if (options_.answered) options_.answered(response.status);
        if (!head_only && response.blob)
            delivered =
                delivered &&
                connection.write(
                    std::string_view(*response.blob).substr(response.offset, response.length));
        delivered = connection.flush() && delivered;
        if (delivered && !head_only && response.stream)
            response.stream([&connection](std::string_view piece) {
                return connection.write(piece) && connection.flush();
            });
        return delivered;
    }

    ListenerOptions options_;
    HttpHandler handler_;
    ConnectionPool pool_;
    std::atomic<bool> stopping_{false};
    std::atomic<std::uint64_t> upload_bytes_{0};
    int listening_socket_ = -1;
    std::string host_;
    int port_ = 0;
};

Listener::Listener(ListenerOptions options, HttpHandler handler)
    : server_(std::make_unique<Server>(std::move(options), std::move(handler))) {}
Listener::~Listener() = default;

int Listener::bind(const std::string& host, int port) {
    return server_->bind_and_listen(host, port);
}
void Listener::run() { server_->run(); }
void Listener::stop() { server_->stop_soon(); }
std::size_t Listener::connections() { return server_->connections(); }

}  // namespace kiln
