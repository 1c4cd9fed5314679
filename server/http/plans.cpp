// SPDX-License-Identifier: Apache-2.0
#include "server/base/error.h"
#include "server/http/documents.h"
#include "server/http/query.h"
#include "server/http/service.h"
#include "server/scene/plan_options.h"

namespace kiln {

namespace {

HttpResponse post_plan(const HttpRequest& request) {
    expect_scene(request);
    const PlanRequest asked = read_plan_request(request.query);
    return json_response(
        200, to_json(plan_scene(read_scene(request.body, asked.choice), asked.options)));
}

}  // namespace

void add_plan_routes(Router& router, Service&) {
    router.add("POST", "/v1/plans",
               [](const HttpRequest& request, const std::string&) { return post_plan(request); });
}

}  // namespace kiln
