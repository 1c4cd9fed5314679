// SPDX-License-Identifier: Apache-2.0
#include "server/base/error.h"
#include "server/http/documents.h"
#include "server/http/query.h"
#include "server/http/service.h"

namespace kiln {

namespace {

/// Proxies cut a silent stream after 30 s or more.
constexpr std::chrono::seconds kHeartbeat{10};

bool worth_telling(const JobRecord& before, const JobRecord& now) {
    return before.state != now.state || before.progress != now.progress ||
           before.standard_error_max != now.standard_error_max || before.attempts != now.attempts;
}

std::string event_text(std::uint64_t number, bool state, const JobRecord& job) {
    return "id: " + std::to_string(number) + "\nevent: " + (state ? "state" : "progress") +
           "\ndata: " + job_document(job, false, false) + "\n\n";
}

/// Tells a job's changes until it has ended, the client is gone, or the server stops.
void tell(Service& service, JobRecord job, const StreamWriter& write) {
    using Clock = std::chrono::steady_clock;
    Watch watch(service.parts().changes, job.id, Changes::Interest::progress);
    std::uint64_t number = 1;
    if (!write("retry: 1000\n\n" + event_text(number++, true, job))) return;
    Clock::time_point told = Clock::now();
    while (!is_final(job.state) && !service.parts().changes.closed()) {
        watch.wait(Changes::kLookInterval);
        JobRecord now = service.find(job.id);
        if (worth_telling(job, now)) {
            if (!write(event_text(number++, job.state != now.state, now))) return;
            told = Clock::now();
        } else if (Clock::now() - told >= kHeartbeat) {
            if (!write(": still here\n\n")) return;
            told = Clock::now();
        }
        job = std::move(now);
    }
}

HttpResponse get_events(Service& service, const HttpRequest& request, const std::string& id) {
    expect_only(request, {});
    JobRecord job = service.find(id);
    auto place = std::make_shared<Service::WaitingPlace>(service);
    if (!place->taken())
        throw Error("too_many_waiting", "too many requests wait already; poll the job instead");
    HttpResponse response;
    response.content_type = "text/event-stream";
    response.headers = {{"Cache-Control", "no-store"}, {"X-Accel-Buffering", "no"}};
    response.stream = [&service, job = std::move(job), place](const StreamWriter& write) {
        tell(service, job, write);
    };
    return response;
}

}  // namespace

void add_event_routes(Router& router, Service& service) {
    router.add("GET", "/v1/jobs/{id}/events",
               [&](const HttpRequest& request, const std::string& id) {
                   return get_events(service, request, id);
               });
}

}  // namespace kiln
