// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "server/base/error.h"
#include "server/http/documents.h"
#include "server/http/query.h"
#include "server/http/service.h"
#include "server/spec/spec.h"

namespace kiln {

namespace {

std::size_t workers_alive(const Service& service) {
    const auto workers = service.parts().workers();
    return static_cast<std::size_t>(std::count_if(
        workers.begin(), workers.end(), [](const WorkerStatus& worker) { return worker.alive; }));
}

HttpResponse get_readiness(Service& service) {
    if (service.draining()) throw Error("draining", "the server is stopping");
    service.parts().store.counts();  // throws store_failed, which is the answer then
    if (service.parts().settings.workers > 0 && workers_alive(service) == 0)
        throw Error("not_ready", "no worker is alive; one is being started");
    return json_response(200, R"({"status":"ready"})");
}

HttpResponse get_metrics(Service& service) {
    Gauges gauges{.jobs = std::nullopt,
                  .connections = service.parts().connections(),
                  .waiting = service.waiting(),
                  .workers_alive = workers_alive(service)};
    try {
        gauges.jobs = service.parts().store.counts();
    } catch (const Error&) {
        // The other figures are worth most while the store fails; /readyz tells that it does.
    }
    HttpResponse response;
    response.content_type = "text/plain; version=0.0.4";
    response.body = metrics_text(service.parts().metrics, gauges);
    return response;
}

}  // namespace

void add_operation_routes(Router& router, Service& service) {
    const auto add = [&](const std::string& path, std::function<HttpResponse()> answer) {
        router.add("GET", path,
                   [answer = std::move(answer)](const HttpRequest& request, const std::string&) {
                       expect_only(request, {});
                       return answer();
                   });
    };
    add("/healthz", [] { return json_response(200, R"({"status":"alive"})"); });
    add("/readyz", [&service] { return get_readiness(service); });
    add("/metrics", [&service] { return get_metrics(service); });
    add("/openapi.json", [] { return json_response(200, std::string(openapi_text())); });
    add("/v1/capabilities",
        [&service] { return json_response(200, capabilities_document(service)); });
}

}  // namespace kiln
