// SPDX-License-Identifier: Apache-2.0
#include "server/http/serve.h"

#include <unistd.h>

#include <csignal>
#include <ctime>
#include <string>
#include <thread>

#include "server/base/log.h"
#include "server/http/listener.h"
#include "server/http/service.h"
#include "server/http/supervisor.h"

namespace kiln {

namespace {

ListenerOptions listener_options(const Settings& settings, Metrics& metrics) {
    using std::chrono::seconds;
    ListenerOptions options;
    options.connections_max = static_cast<std::size_t>(settings.connections_max);
    options.timeouts = {.header = seconds(settings.header_timeout_s),
                        .idle = seconds(settings.idle_timeout_s),
                        .body = seconds(settings.body_timeout_s),
                        .send = seconds(settings.send_timeout_s)};
    options.body_bytes_max = [&settings](const std::string& path) {
        return body_bytes_max(settings, path);
    };
    options.streams_body = streams_body;
    options.answered = [&metrics](int status) {
        ++metrics.answers[static_cast<std::size_t>(status) % metrics.answers.size()];
    };
    return options;
}

void announce(const std::string& host, int port) {
    const bool v6 = host.find(':') != std::string::npos;
    const std::string line =
        "listening on http://" + (v6 ? "[" + host + "]" : host) + ":" + std::to_string(port) + "\n";
    [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, line.data(), line.size());
}

/// Returns at the next SIGTERM or SIGINT, or after `time`; true when there was one.
bool wait_for_signal(std::chrono::milliseconds time) {
    sigset_t ends;
    sigemptyset(&ends);
    sigaddset(&ends, SIGTERM);
    sigaddset(&ends, SIGINT);
    const timespec span{.tv_sec = time.count() / 1000, .tv_nsec = time.count() % 1000 * 1000000};
    return sigtimedwait(&ends, nullptr, &span) > 0;
}

}  // namespace

int serve(const Settings& settings, const Identity& identity, const Bounds& bounds, JobStore& jobs,
          BlobStore& blobs, MeasurementStore& measurements) {
    Changes changes;
    Metrics metrics;
    Supervisor supervisor(settings, jobs, changes, metrics);
    Listener* listening = nullptr;
    Service service({.store = jobs,
                     .blobs = blobs,
                     .measurements = measurements,
                     .settings = settings,
                     .changes = changes,
                     .metrics = metrics,
                     .engine = identity.engine,
                     .readers = identity.readers,
                     .bounds = bounds,
                     .ring = [&supervisor] { supervisor.ring(); },
                     .workers = [&supervisor] { return supervisor.workers(); },
                     .connections = [&listening] { return listening->connections(); }});
    const Router router = make_router(service);
    Listener listener(listener_options(settings, metrics),
                      [&router](const HttpRequest& request) { return router.dispatch(request); });
    listening = &listener;

    const Endpoint endpoint = parse_endpoint(settings.listen);
    const int port = listener.bind(endpoint.host, endpoint.port);
    supervisor.start();
    std::thread accepting([&listener] { listener.run(); });
    announce(endpoint.host, port);

    while (!wait_for_signal(std::chrono::hours(1))) continue;
    log_line("stopping");
    service.drain();
    supervisor.begin_stop();
    while (!supervisor.stopped())
        if (wait_for_signal(std::chrono::milliseconds(20))) supervisor.hurry();
    changes.close();
    listener.stop();
    accepting.join();
    log_line("stopped");
    return 0;
}

}  // namespace kiln
