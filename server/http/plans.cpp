// SPDX-License-Identifier: Apache-2.0
#include <memory>
#include <semaphore>

#include "server/base/error.h"
#include "server/http/bounds.h"
#include "server/http/documents.h"
#include "server/http/query.h"
#include "server/http/service.h"
#include "server/scene/plan_options.h"

namespace kiln {

namespace {

using Places = std::counting_semaphore<kPlansMax>;

/// One of the few scenes that are read at a time: each may take a core and hundreds of megabytes.
class Place {
  public:
    explicit Place(Places& places) : places_(places) {
        if (!places_.try_acquire_for(kPlanPatienceMax))
            throw Error("too_many_plans", "other scenes are being read; try again soon");
    }
    ~Place() { places_.release(); }
    Place(const Place&) = delete;
    Place& operator=(const Place&) = delete;

  private:
    Places& places_;
};

HttpResponse post_plan(Places& places, const HttpRequest& request) {
    expect_scene(request);
    const PlanRequest asked = read_plan_request(request.query);
    const Place place(places);
    return json_response(
        200, to_json(plan_scene(read_scene(request.body, asked.choice), asked.options)));
}

}  // namespace

void add_plan_routes(Router& router, Service&) {
    const auto places = std::make_shared<Places>(kPlansMax);
    router.add("POST", "/v1/plans", [places](const HttpRequest& request, const std::string&) {
        return post_plan(*places, request);
    });
}

}  // namespace kiln
