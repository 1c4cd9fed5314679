// SPDX-License-Identifier: Apache-2.0
#include "server/http/query.h"

#include <strings.h>

#include <algorithm>
#include <charconv>

#include "server/base/error.h"
#include "server/base/log.h"
#include "server/spec/limits.h"

namespace kiln {

void expect_only(const HttpRequest& request, std::initializer_list<std::string_view> names) {
    for (const auto& [name, value] : request.query) {
        if (std::find(names.begin(), names.end(), name) != names.end()) continue;
        std::string known;
        for (const std::string_view one : names)
            known += (known.empty() ? "" : ", ") + std::string(one);
        throw Error("bad_query", "\"" + escaped(name) + "\" is not a parameter here; " +
                                     (known.empty() ? "there are none" : "there is " + known));
    }
}

std::chrono::milliseconds wait_of(const HttpRequest& request) {
    const auto found = request.query.find("wait");
    if (found == request.query.end()) return std::chrono::milliseconds(0);
    const std::string& text = found->second;
    const char* end = text.data() + text.size();
    double seconds = 0;
    const auto [stopped, error] = std::from_chars(text.data(), end, seconds);
    const auto max = static_cast<double>(limits().wait_s_max);
    if (error != std::errc() || stopped != end || !(seconds >= 0 && seconds <= max))
        throw Error("bad_query",
                    "wait: give seconds from 0 to " + std::to_string(limits().wait_s_max));
    return std::chrono::milliseconds(static_cast<std::int64_t>(seconds * 1000));
}

std::int64_t integer_of(const HttpRequest& request, const std::string& name, std::int64_t fallback,
                        std::int64_t min, std::int64_t max) {
    const auto found = request.query.find(name);
    if (found == request.query.end()) return fallback;
    const std::string& text = found->second;
    const char* end = text.data() + text.size();
    std::int64_t value = 0;
    const auto [stopped, error] = std::from_chars(text.data(), end, value);
    if (error != std::errc() || stopped != end || value < min || value > max)
        throw Error("bad_query", name + ": give an integer from " + std::to_string(min) + " to " +
                                     std::to_string(max));
    return value;
}

namespace {
/// The media type of a request's body, without parameters.
class MediaType {
  public:
    explicit MediaType(const HttpRequest& request) {
        const std::string_view type = request.header("content-type").value_or("");
        word_ = type.substr(0, type.find(';'));
        while (!word_.empty() && word_.back() == ' ') word_.remove_suffix(1);
    }
    bool empty() const { return word_.empty(); }
    bool is(std::string_view name) const {
        return word_.size() == name.size() &&
               strncasecmp(word_.data(), name.data(), name.size()) == 0;
    }

  private:
    std::string_view word_;
};
}  // namespace

void expect_scene(const HttpRequest& request) {
    const MediaType type(request);
    for (const char* name :
         {"model/gltf+json", "model/gltf-binary", "application/json", "application/octet-stream"})
        if (type.is(name)) return;
    throw Error("wrong_type",
                "send the scene with Content-Type: model/gltf+json, model/gltf-binary, "
                "application/json or application/octet-stream");
}

namespace {
void expect_type(const HttpRequest& request, std::string_view wanted, const std::string& what) {
    const MediaType type(request);
    if (type.is(wanted)) return;
    // What `curl --data` and urllib say unless told otherwise. Any web page can make a browser send
    // such a request to a loopback port, but not without Origin; JSON it cannot send without asking
    // first.
    const bool simple = type.empty() || type.is("application/x-www-form-urlencoded");
    if (simple && !request.header("origin")) return;
    throw Error("wrong_type", "send the " + what + " with Content-Type: " + std::string(wanted));
}
}  // namespace

void expect_json(const HttpRequest& request) {
    expect_type(request, "application/json", "document");
}

void expect_bytes(const HttpRequest& request) {
    expect_type(request, "application/octet-stream", "file");
}

}  // namespace kiln
