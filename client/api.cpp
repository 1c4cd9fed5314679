// SPDX-License-Identifier: Apache-2.0
#include "client/api.h"

#include <algorithm>
#include <cstdio>
#include <thread>

#include "client/failure.h"
#include "server/base/sha256.h"
#include "server/spec/limits.h"

namespace kiln::client {

namespace {

using namespace std::chrono_literals;

constexpr auto kProbeTimeout = 1s;    // a server on this machine answers within milliseconds
constexpr auto kAnswerTimeout = 30s;  // beyond the wait that a request asks for
constexpr auto kPatience = 60s;       // with a server that says it is full
constexpr std::size_t kListBytesMax = 64u << 20;
// 4096² texels of 64 float channels, uncompressed, are 4.3 GB; a job's work limit leaves far less
// than that.
constexpr std::size_t kImageBytesMax = std::size_t{4} << 30;

std::string wait_query(double wait_s) {
    char text[32];
    std::snprintf(text, sizeof text, "?wait=%.3g", wait_s);
    return text;
}

HttpRequest request(const std::string& method, const std::string& path) {
    HttpRequest result;
    result.method = method;
    result.url = path;
    result.timeout = kAnswerTimeout;
    return result;
}

Failure refusal(const std::string& url, const HttpAnswer& answer) {
    ProblemDocument problem =
        read_problem(answer.body)
            .value_or(
                ProblemDocument{.code = "http_error", .detail = "no Kiln server?", .problems = {}});
    // 400 and 422 judge the job, 413 its size; the rest is not the document's fault.
    if (answer.status == 422 || answer.status == 413 ||
        (answer.status == 400 && !problem.problems.empty()))
        return {Exit::invalid_job, problem.code, problem.detail, std::move(problem.problems)};
    const bool unfit = answer.status == 429 || answer.status >= 500;  // another server might do
    return {unfit ? Exit::unreachable : Exit::failed, problem.code,
            url + " answers " + std::to_string(answer.status) + ": " + problem.detail};
}

std::string digest_of(const std::string& etag) {
    std::string digest = etag;
    if (digest.size() >= 2 && digest.front() == '"' && digest.back() == '"')
        digest = digest.substr(1, digest.size() - 2);
    return is_sha256_hex(digest) ? digest : "";
}

}  // namespace

Api::Api(std::string url, std::function<bool()> stop)
    : url_(std::move(url)), stop_(stop), http_(std::move(stop)) {
    while (url_.ends_with('/')) url_.pop_back();
    if (url_.find("://") == std::string::npos) url_ = "http://" + url_;
}

HttpAnswer Api::send(HttpRequest http_request) {
    http_request.url = url_ + http_request.url;
    return http_.send(http_request);
}

HttpAnswer Api::ask(HttpRequest http_request) {
    const auto give_up = std::chrono::steady_clock::now() + kPatience;
    while (true) {
        HttpAnswer answer = send(http_request);
        if (answer.status >= 200 && answer.status < 300) return answer;
        const bool full = answer.status == 429 || answer.status == 503;
        const auto again = std::chrono::steady_clock::now() +
                           std::chrono::seconds(std::max(1, answer.retry_after_s));
        if (!full || again > give_up) throw refusal(url_, answer);
        while (std::chrono::steady_clock::now() < again) {
            if (stop_()) throw Cancelled();
            std::this_thread::sleep_for(50ms);
        }
    }
}

JobStatus Api::job_in(const HttpAnswer& answer) {
    auto job = read_job_status(answer.body);
    if (!job || !is_sha256_hex(job->id))
        throw Failure(Exit::failed, "no_kiln_server", url_ + " does not answer like a Kiln server");
    return std::move(*job);
}

bool Api::answers() {
    try {
        HttpRequest probe = request("GET", "/v1/capabilities");
        probe.connect_timeout = kProbeTimeout;
        probe.timeout = kProbeTimeout;
        const HttpAnswer answer = send(probe);
        return answer.status == 200 && is_capabilities(answer.body);
    } catch (const Failure&) {
        return false;
    }
}

JobStatus Api::submit(const std::string& job, double wait_s) {
    HttpRequest post = request("POST", "/v1/jobs" + wait_query(wait_s));
    post.body = job;
    post.timeout += std::chrono::milliseconds(static_cast<long>(1000 * wait_s));
    return job_in(ask(std::move(post)));
}

std::vector<JobStatus> Api::submit_batch(const std::vector<std::string>& jobs) {
    HttpRequest post = request("POST", "/v1/batches");
    post.body = batch_json(jobs);
    post.answer_bytes_max = kListBytesMax;
    auto answers = read_batch_answer(ask(std::move(post)).body);
    if (!answers || answers->size() != jobs.size())
        throw Failure(Exit::failed, "no_kiln_server", url_ + " does not answer like a Kiln server");
    std::vector<JobStatus> result;
    for (std::size_t i = 0; i < jobs.size(); ++i) {
        HttpAnswer one;
        one.status = (*answers)[i].status;
        one.body = (*answers)[i].document;
        // A full queue takes the rest when there is room: alone, with patience.
        if (one.status == 429 || one.status == 503)
            result.push_back(submit(jobs[i], 0));
        else if (one.status < 200 || one.status >= 300)
            throw refusal(url_, one);
        else
            result.push_back(job_in(one));
    }
    return result;
}

Makers Api::makers() { return read_makers(ask(request("GET", "/v1/capabilities")).body); }

JobStatus Api::status(const std::string& id, double wait_s) {
    HttpRequest get = request("GET", "/v1/jobs/" + id + wait_query(wait_s));
    get.timeout += std::chrono::milliseconds(static_cast<long>(1000 * wait_s));
    return job_in(ask(std::move(get)));
}

std::string Api::image(const std::string& id) {
    HttpRequest get = request("GET", "/v1/jobs/" + id + "/image");
    get.answer_bytes_max = kImageBytesMax;
    get.timeout = 600s;  // 4 GB at 7 MB/s
    HttpAnswer answer = ask(std::move(get));
    const std::string promised = digest_of(answer.etag);
    if (promised.empty())
        throw Failure(Exit::failed, "bad_image",
                      url_ + " sent an image without its SHA-256 as ETag");
    if (const std::string got = sha256_hex(answer.body); got != promised)
        throw Failure(Exit::failed, "bad_image",
                      url_ + " sent an image whose SHA-256 is " + got + ", not " + promised +
                          " as promised: it was damaged on the way");
    return std::move(answer.body);
}

std::string Api::report(const std::string& id) {
    HttpRequest get = request("GET", "/v1/jobs/" + id + "/report");
    get.answer_bytes_max = kListBytesMax;  // a side-car may be in it
    HttpAnswer answer = ask(std::move(get));
    if (!read_report(answer.body))
        throw Failure(Exit::failed, "bad_report", url_ + " sent a report that cannot be read");
    return std::move(answer.body);
}

std::string Api::sidecar(const std::string& id) {
    HttpRequest get = request("GET", "/v1/jobs/" + id + "/sidecar");
    get.answer_bytes_max = kListBytesMax;
    return ask(std::move(get)).body;
}

bool Api::has_measurement(const std::string& digest) {
    HttpRequest get = request("GET", "/v1/measurements/sha256:" + digest);
    get.answer_bytes_max = kListBytesMax;
    const HttpAnswer answer = send(std::move(get));
    if (answer.status == 404) return false;
    if (answer.status != 200) throw refusal(url_, answer);
    return true;
}

std::string Api::upload(std::string bytes) {
    HttpRequest post = request("POST", "/v1/measurements");
    post.content_type = "application/octet-stream";
    post.body = std::move(bytes);
    post.answer_bytes_max = kListBytesMax;
    post.timeout = 600s;
    return ask(std::move(post)).body;
}

bool Api::cancel(const std::string& id) {
    const HttpAnswer answer = send(request("DELETE", "/v1/jobs/" + id));
    if (answer.status == 409) return false;
    if (answer.status < 200 || answer.status >= 300) throw refusal(url_, answer);
    return true;
}

void Api::release(const std::string& id) {
    send(request("DELETE", "/v1/jobs/" + id + "?release=true"));
}

std::vector<JobStatus> Api::list(const std::string& state, std::size_t count_max) {
    const auto page_max = static_cast<std::size_t>(limits().list_limit_max);
    std::vector<JobStatus> jobs;
    std::string cursor;
    while (jobs.size() < count_max) {
        HttpRequest get = request(
            "GET", "/v1/jobs?limit=" + std::to_string(std::min(count_max - jobs.size(), page_max)) +
                       (state.empty() ? "" : "&state=" + state) +
                       (cursor.empty() ? "" : "&cursor=" + url_encoded(cursor)));
        get.answer_bytes_max = kListBytesMax;
        auto page = read_job_list(ask(std::move(get)).body);
        if (!page)
            throw Failure(Exit::failed, "no_kiln_server",
                          url_ + " does not answer like a Kiln server");
        for (JobStatus& job : page->jobs) jobs.push_back(std::move(job));
        // A page with a cursor and no jobs would never end.
        if (page->next_cursor.empty() || page->jobs.empty()) break;
        cursor = page->next_cursor;
    }
    return jobs;
}

}  // namespace kiln::client
