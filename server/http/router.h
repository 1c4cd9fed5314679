// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "server/http/message.h"

namespace kiln {

/// Exact paths, in which one segment may be {id}: a job's id and nothing else. HEAD is answered as
/// GET.
class Router {
  public:
    using Handler = std::function<HttpResponse(const HttpRequest&, const std::string& id)>;

    void add(const std::string& method, const std::string& pattern, Handler handler);
    /// Answers 404 for an unknown path and 405 with Allow for a known one under another method.
    HttpResponse dispatch(const HttpRequest& request) const;

  private:
    struct Route {
        std::string method, before_id, after_id;
        bool has_id = false;
        Handler handler;
    };
    std::vector<Route> routes_;
};

}  // namespace kiln
