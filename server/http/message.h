// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace kiln {

/// Takes a piece of a body that is not held as a whole.
using BodySink = std::function<void(std::string_view)>;

/// A request past the guard: every size is bounded, the body is complete or asked for piece by
/// piece, nothing is repeated that may stand only once.
struct HttpRequest {
    std::string method;  ///< upper case
    std::string
        path;  ///< as sent, at most kPathBytesMax visible ASCII characters, no percent decoding
    std::map<std::string, std::string> query;    ///< decoded; a repeated name is refused
    std::map<std::string, std::string> headers;  ///< names in lower case
    std::string body;
    std::uint64_t content_length = 0;
    /// Of a path that streams (ListenerOptions), in place of `body`: gives the content_length bytes
    /// to the sink, in order. Throws Error("timeout"), and what the sink throws.
    std::function<void(const BodySink&)> receive;
    bool keep_alive = true;
    /// True once the client has closed its end: whoever waits on its behalf may stop.
    std::function<bool()> client_gone = [] { return false; };

    std::optional<std::string_view> header(const std::string& name) const {
        const auto found = headers.find(name);
        if (found == headers.end()) return std::nullopt;
        return found->second;
    }
};

/// Writes a piece of a streamed answer to the client at once; false when the client is gone.
using StreamWriter = std::function<bool(std::string_view)>;

/// An answer. The content is `body`, or `length` bytes of `blob` from `offset` (sent from where
/// they lie, shared by all who read them), or what `stream` writes until it returns.
struct HttpResponse {
    int status = 200;
    std::vector<std::pair<std::string, std::string>> headers;
    std::string content_type;
    std::string body;
    std::shared_ptr<const std::string> blob;
    std::size_t offset = 0, length = 0;
    std::function<void(const StreamWriter&)> stream;
};

using HttpHandler = std::function<HttpResponse(const HttpRequest&)>;

}  // namespace kiln
