// SPDX-License-Identifier: Apache-2.0
#include "server/http/problems.h"

#include <array>
#include <random>

#include "server/base/error.h"
#include "server/base/log.h"
#include "server/scene/scene.h"
#include "server/spec/problem_document.h"

namespace kiln {

namespace {

struct Row {
    std::string_view code;
    int status;
    std::string_view title;
};

constexpr std::array kRows{
    Row{"malformed", 400, "Malformed request"},
    Row{"bad_request", 400, "Malformed request"},
    Row{"bad_query", 400, "Malformed query"},
    Row{"bad_cursor", 400, "Malformed query"},
    Row{"not_found", 404, "Not found"},
    Row{"unknown_job", 404, "No such job"},
    Row{"missing_measurement", 404, "No such measurement"},
    Row{"no_sidecar", 404, "The job has no side-car"},
    Row{"wrong_extension", 404, "The image has another format"},
    Row{"method_not_allowed", 405, "Method not allowed"},
    Row{"timeout", 408, "Request timed out"},
    Row{"not_done", 409, "The job has no result"},
    Row{"finished", 409, "The job has finished"},
    Row{"gone", 410, "The result was evicted"},
    Row{"length_required", 411, "Content-Length required"},
    Row{"too_large", 413, "Request too large"},
    Row{"uri_too_long", 414, "Address too long"},
    Row{"wrong_type", 415, "Wrong content type"},
    Row{"bad_range", 416, "Range not satisfiable"},
    Row{"bad_expectation", 417, "Expectation failed"},
    Row{"invalid_job", 422, "Invalid job"},
    Row{"invalid_scene", 422, "Invalid scene"},
    Row{"malformed_measurement", 422, "Malformed measurement"},
    Row{"unknown_measurement", 422, "No format of measurements"},
    Row{"unreadable_measurement", 422, "Measurement not read"},
    Row{"measurement_too_large", 422, "Measurement too large"},
    Row{"queue_full", 429, "The queue is full"},
    Row{"headers_too_large", 431, "Request header too large"},
    Row{"store_failed", 503, "The store fails"},
    Row{"draining", 503, "The server is stopping"},
    Row{"too_many_connections", 503, "Too many connections"},
    Row{"too_many_plans", 503, "Too many scenes"},
    Row{"too_many_uploads", 503, "Too many uploads"},
    Row{"measurements_full", 503, "No room for measurements"},
    Row{"too_many_waiting", 503, "Too many waiting requests"},
    Row{"too_many_downloads", 503, "Too many downloads"},
    Row{"not_ready", 503, "Not ready"},
    Row{"bad_version", 505, "HTTP version not supported"},
};

const Row& row_of(std::string_view code) {
    static constexpr Row kInternal{"internal", 500, "Internal error"};
    for (const Row& row : kRows)
        if (row.code == code) return row;
    return kInternal;
}

/// Ties an answer to its log line without telling the client what went wrong inside.
std::string new_error_id() {
    static constexpr char kDigits[] = "0123456789abcdef";
    std::random_device random;
    std::string id;
    for (int i = 0; i < 12; ++i) id += kDigits[random() & 15];
    return id;
}

}  // namespace

int status_of(std::string_view code) { return row_of(code).status; }

HttpResponse problem(std::string_view code, std::string_view detail,
                     const std::vector<Problem>& problems) {
    const Row& row = row_of(code);
    HttpResponse response;
    response.status = row.status;
    response.content_type = "application/problem+json";
    response.body = problem_document(row.code, row.status, row.title, detail, problems);
    if (row.status == 429 || row.status == 503) add_retry_after(response, 1);
    return response;
}

HttpResponse problem_of(const std::exception& failure) {
    if (const auto* malformed = dynamic_cast<const Malformed*>(&failure))
        return problem(malformed->code(), malformed->what(), malformed->problems);
    if (const auto* invalid = dynamic_cast<const InvalidJob*>(&failure))
        return problem("invalid_job", invalid->what(), invalid->problems);
    if (const auto* scene = dynamic_cast<const InvalidScene*>(&failure))
        return problem("invalid_scene", scene->what(), scene->problems);
    const auto* error = dynamic_cast<const Error*>(&failure);
    // What the store or an unforeseen failure says may tell of paths and statements.
    const bool inner = error == nullptr || error->code() == "store_failed" ||
                       status_of(error->code()) == row_of("internal").status;
    if (!inner) return problem(error->code(), error->what());
    const std::string id = new_error_id();
    log_line("request_failed", {{"id", id}, {"detail", failure.what()}});
    return problem(error != nullptr ? error->code() : "internal",
                   "the server could not do this; its log has the reason under " + id);
}

void add_retry_after(HttpResponse& response, int seconds) {
    response.headers.emplace_back("Retry-After", std::to_string(seconds));
}

}  // namespace kiln
