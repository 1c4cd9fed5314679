// SPDX-License-Identifier: Apache-2.0
#include "server/base/error.h"
#include "server/base/log.h"
#include "server/http/documents.h"
#include "server/http/problems.h"
#include "server/http/query.h"
#include "server/http/service.h"
#include "server/spec/limits.h"

namespace kiln {

namespace {

constexpr int kRetryAfterSeconds = 1;

HttpResponse answer_of(const JobRecord& job, bool cached) {
    HttpResponse response =
        json_response(is_final(job.state) ? 200 : 202, job_document(job, cached, true));
    if (response.status == 202) {
        response.headers.emplace_back("Location", "/v1/jobs/" + job.id);
        add_retry_after(response, kRetryAfterSeconds);
    }
    return response;
}

HttpResponse post_job(Service& service, const HttpRequest& request) {
    expect_only(request, {"wait"});
    expect_json(request);
    const std::chrono::milliseconds wait = wait_of(request);
    Admitted admitted = service.admit(request.body);
    if (wait.count() > 0 && !is_final(admitted.job.state)) {
        // The job is taken in: with no place to wait the client polls.
        const Service::WaitingPlace place(service);
        if (place.taken())
            admitted.job = service.wait_for_end(std::move(admitted.job), wait, request);
    }
    return answer_of(admitted.job, admitted.cached);
}

HttpResponse get_job(Service& service, const HttpRequest& request, const std::string& id) {
    expect_only(request, {"wait"});
    const std::chrono::milliseconds wait = wait_of(request);
    JobRecord job = service.find(id);
    const bool cached = job.state == JobState::done;
    if (wait.count() > 0 && !is_final(job.state)) {
        const Service::WaitingPlace place(service);
        if (!place.taken())
            throw Error("too_many_waiting", "too many requests wait already; ask without wait");
        job = service.wait_for_end(std::move(job), wait, request);
    }
    return json_response(200, job_document(job, cached, true));
}

HttpResponse delete_job(Service& service, const HttpRequest& request, const std::string& id) {
    expect_only(request, {"release"});
    const auto release = request.query.find("release");
    if (release != request.query.end() && release->second != "true")
        throw Error("bad_query", "release: give true, or leave it out");
    if (release != request.query.end() && !service.release(id))
        return json_response(200, job_document(service.find(id), false, true));
    const ServiceParts& parts = service.parts();
    const CancelResult result = parts.store.cancel(id);
    if (result == CancelResult::unknown) throw Error("unknown_job", "there is no job with this id");
    const JobRecord job = service.find(id);
    if (result == CancelResult::already_finished)
        throw Error("finished", "the job is " + std::string(to_word(job.state)) +
                                    "; nothing is left to cancel");
    parts.ring();
    parts.changes.notify(id, Changes::Interest::state);
    return json_response(result == CancelResult::cancelled ? 200 : 202,
                         job_document(job, false, true));
}

HttpResponse list_jobs(Service& service, const HttpRequest& request) {
    expect_only(request, {"state", "limit", "cursor"});
    const auto limit =
        integer_of(request, "limit", limits().list_limit_default, 1, limits().list_limit_max);
    std::optional<JobState> state;
    if (const auto word = request.query.find("state"); word != request.query.end()) {
        state = job_state_from(word->second);
        if (!state)
            throw Error("bad_query", "state: give queued, running, done, failed or cancelled");
    }
    const auto cursor = request.query.find("cursor");
    const std::string from = cursor == request.query.end() ? "" : cursor->second;
    const JobPage page = service.parts().store.list(state, static_cast<int>(limit), from);
    HttpResponse response = json_response(200, page_document(page));
    if (!page.next_cursor.empty()) {
        std::string next =
            "</v1/jobs?limit=" + std::to_string(limit) + "&cursor=" + page.next_cursor;
        if (state) next += "&state=" + std::string(to_word(*state));
        response.headers.emplace_back("Link", next + ">; rel=\"next\"");
    }
    return response;
}

}  // namespace

void add_job_routes(Router& router, Service& service) {
    router.add("POST", "/v1/jobs", [&](const HttpRequest& request, const std::string&) {
        return post_job(service, request);
    });
    router.add("GET", "/v1/jobs", [&](const HttpRequest& request, const std::string&) {
        return list_jobs(service, request);
    });
    router.add("GET", "/v1/jobs/{id}", [&](const HttpRequest& request, const std::string& id) {
        return get_job(service, request, id);
    });
    router.add("DELETE", "/v1/jobs/{id}", [&](const HttpRequest& request, const std::string& id) {
        return delete_job(service, request, id);
    });
}

}  // namespace kiln
