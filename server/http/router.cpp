// SPDX-License-Identifier: Apache-2.0
#include "server/http/router.h"

#include <algorithm>

#include "server/base/sha256.h"
#include "server/http/problems.h"

namespace kiln {

namespace {
constexpr std::string_view kIdMark = "{id}";
constexpr std::size_t kIdLength = 64;

std::string allow_of(const std::vector<std::string>& methods) {
    std::string allow;
    for (const std::string& method : methods) allow += (allow.empty() ? "" : ", ") + method;
    return allow;
}
}  // namespace

void Router::add(const std::string& method, const std::string& pattern, Handler handler) {
    const std::size_t mark = pattern.find(kIdMark);
    Route route{method, pattern.substr(0, mark), "", mark != pattern.npos, std::move(handler)};
    if (route.has_id) route.after_id = pattern.substr(mark + kIdMark.size());
    routes_.push_back(std::move(route));
}

HttpResponse Router::dispatch(const HttpRequest& request) const {
    const std::string& method = request.method == "HEAD" ? std::string("GET") : request.method;
    const std::string_view path = request.path;
    std::vector<std::string> allowed;
    for (const Route& route : routes_) {
        std::string id;
        if (route.has_id) {
            const std::size_t size = route.before_id.size() + kIdLength + route.after_id.size();
            if (path.size() != size || path.substr(0, route.before_id.size()) != route.before_id ||
                path.substr(size - route.after_id.size()) != route.after_id)
                continue;
            id = path.substr(route.before_id.size(), kIdLength);
            if (!is_sha256_hex(id)) continue;
        } else if (path != route.before_id) {
            continue;
        }
        if (route.method == method) return route.handler(request, id);
        allowed.push_back(route.method);
        if (route.method == "GET") allowed.push_back("HEAD");
    }
    if (allowed.empty()) return problem("not_found", "there is nothing at this path");
    HttpResponse response = problem("method_not_allowed", "this path takes " + allow_of(allowed));
    response.headers.emplace_back("Allow", allow_of(allowed));
    return response;
}

}  // namespace kiln
