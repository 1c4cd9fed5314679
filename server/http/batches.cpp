// SPDX-License-Identifier: Apache-2.0
#include "server/spec/batch.h"

#include "server/base/error.h"
#include "server/http/documents.h"
#include "server/http/problems.h"
#include "server/http/query.h"
#include "server/http/service.h"

namespace kiln {

namespace {

HttpResponse answer_one(Service& service, const std::string& job_text) {
    try {
        const Admitted admitted = service.admit(job_text);
        return json_response(is_final(admitted.job.state) ? 200 : 202,
                             job_document(admitted.job, admitted.cached, false));
    } catch (const std::exception& failure) {
        return problem_of(failure);
    }
}

HttpResponse post_batch(Service& service, const HttpRequest& request) {
    expect_only(request, {});
    expect_json(request);
    std::vector<HttpResponse> answers;
    for (const std::string& job_text : batch_jobs(request.body))
        answers.push_back(answer_one(service, job_text));
    return json_response(200, batch_document(answers));
}

}  // namespace

void add_batch_routes(Router& router, Service& service) {
    router.add("POST", "/v1/batches", [&](const HttpRequest& request, const std::string&) {
        return post_batch(service, request);
    });
}

}  // namespace kiln
