// SPDX-License-Identifier: Apache-2.0
#include "server/spec/problem_document.h"

#include <nlohmann/json.hpp>

namespace kiln {

std::string problem_document(std::string_view code, int status, std::string_view title,
                             std::string_view detail, const std::vector<Problem>& problems) {
    using Json = nlohmann::json;
    Json list = Json::array();
    for (const Problem& problem : problems)
        list.push_back({{"pointer", problem.pointer}, {"message", problem.message}});
    const Json document = {{"type", "about:blank"}, {"title", title},
                           {"status", status},      {"code", code},
                           {"detail", detail},      {"problems", std::move(list)}};
    return document.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace kiln
