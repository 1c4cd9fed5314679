// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

namespace kiln::client {

struct HttpRequest {
    std::string method;  ///< GET, POST or DELETE
    std::string url;
    std::string body;                               ///< sent with POST only
    std::string content_type = "application/json";  ///< of the body
    std::size_t answer_bytes_max = 1 << 20;
    std::chrono::milliseconds connect_timeout{3000};
    std::chrono::milliseconds timeout{30000};
};

struct HttpAnswer {
    long status = 0;
    std::string body;
    std::string etag;       ///< as sent, quotes included
    int retry_after_s = 0;  ///< 0 where the answer has none
};

/// RFC 3986 percent-encoding of all but the unreserved characters.
std::string url_encoded(std::string_view text);

/// HTTP by libcurl. One request at a time; connections are kept between requests.
class HttpClient {
  public:
    /// `stop` is asked every 0.1 s; a request that it ends throws Cancelled.
    explicit HttpClient(std::function<bool()> stop);
    ~HttpClient();
    HttpClient(const HttpClient&) = delete;
    HttpClient& operator=(const HttpClient&) = delete;

    /// Any status is an answer. Throws Failure(unreachable) where none came.
    HttpAnswer send(const HttpRequest& request);

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace kiln::client
