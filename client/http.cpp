// SPDX-License-Identifier: Apache-2.0
#include "client/http.h"

#include <curl/curl.h>

#include <algorithm>
#include <cctype>
#include <charconv>

#include "client/failure.h"
#include "server/base/version.h"

namespace kiln::client {

namespace {

constexpr int kPollMs = 100;  // how late a request notices that it should stop
constexpr std::size_t kHeaderBytesMax = 64 << 10;

struct Transfer {
    HttpAnswer answer;
    std::size_t answer_bytes_max = 0;
    std::size_t header_bytes = 0;
    bool too_long = false;
};

std::size_t take_body(char* data, std::size_t, std::size_t count, void* user) {
    auto& transfer = *static_cast<Transfer*>(user);
    if (transfer.answer.body.size() + count > transfer.answer_bytes_max) {
        transfer.too_long = true;
        return 0;
    }
    transfer.answer.body.append(data, count);
    return count;
}

/// The value of header `name` if `line` is that header.
bool header_value(std::string_view line, std::string_view name, std::string_view& value) {
    if (line.size() <= name.size() || line[name.size()] != ':') return false;
    for (std::size_t i = 0; i < name.size(); ++i)
        if (std::tolower(static_cast<unsigned char>(line[i])) != name[i]) return false;
    value = line.substr(name.size() + 1);
    while (!value.empty() && (value.front() == ' ' || value.front() == '\t'))
        value.remove_prefix(1);
    while (!value.empty() && std::isspace(static_cast<unsigned char>(value.back())))
        value.remove_suffix(1);
    return true;
}

std::size_t take_header(char* data, std::size_t, std::size_t count, void* user) {
    auto& transfer = *static_cast<Transfer*>(user);
    transfer.header_bytes += count;
    if (transfer.header_bytes > kHeaderBytesMax) {
        transfer.too_long = true;
        return 0;
    }
    std::string_view value;
    if (header_value({data, count}, "etag", value)) transfer.answer.etag = value;
    if (header_value({data, count}, "retry-after", value))
        std::from_chars(value.data(), value.data() + value.size(), transfer.answer.retry_after_s);
    return count;
}

/// libcurl keeps process-wide state: made before the first handle, released after the last.
struct CurlLibrary {
    CurlLibrary() { curl_global_init(CURL_GLOBAL_DEFAULT); }
    ~CurlLibrary() { curl_global_cleanup(); }
};

bool is_loopback(std::string_view url) {
    for (std::string_view host : {"127.0.0.1", "localhost", "[::1]"})
        if (url.find(host) == std::string_view("http://").size()) return true;
    return false;
}

}  // namespace

std::string url_encoded(std::string_view text) {
    static constexpr char kDigits[] = "0123456789ABCDEF";
    std::string out;
    for (const char c : text) {
        const auto byte = static_cast<unsigned char>(c);
        if (std::isalnum(byte) != 0 || std::string_view("-._~").find(c) != std::string_view::npos) {
            out += c;
        } else {
            out += '%';
            out += kDigits[byte >> 4];
            out += kDigits[byte & 15];
        }
    }
    return out;
}

struct HttpClient::State {
    CurlLibrary library;
    std::function<bool()> stop;
    CURLM* multi = curl_multi_init();
    CURL* easy = curl_easy_init();
    ~State() {
        curl_easy_cleanup(easy);
        curl_multi_cleanup(multi);
    }
    void prepare(const HttpRequest& request, curl_slist* headers, Transfer& transfer);
    CURLcode perform();
};

HttpClient::HttpClient(std::function<bool()> stop) : state_(std::make_unique<State>()) {
    state_->stop = std::move(stop);
    if (state_->multi == nullptr || state_->easy == nullptr)
        throw Failure(Exit::failed, "internal", "libcurl gives no handle");
}
HttpClient::~HttpClient() = default;

void HttpClient::State::prepare(const HttpRequest& request, curl_slist* headers,
                                Transfer& transfer) {
    curl_easy_reset(easy);
    curl_easy_setopt(easy, CURLOPT_URL, request.url.c_str());
    curl_easy_setopt(easy, CURLOPT_PROTOCOLS_STR, "http,https");
    curl_easy_setopt(easy, CURLOPT_NOSIGNAL, 1L);
    curl_easy_setopt(easy, CURLOPT_USERAGENT, (std::string("kiln/") + kVersion).c_str());
    curl_easy_setopt(easy, CURLOPT_CONNECTTIMEOUT_MS,
                     static_cast<long>(request.connect_timeout.count()));
    curl_easy_setopt(easy, CURLOPT_TIMEOUT_MS, static_cast<long>(request.timeout.count()));
    curl_easy_setopt(easy, CURLOPT_HTTPHEADER, headers);
    // A proxy of the environment would look for this machine's own server on another machine.
    if (is_loopback(request.url)) curl_easy_setopt(easy, CURLOPT_PROXY, "");
    if (request.method == "POST") {
        curl_easy_setopt(easy, CURLOPT_POST, 1L);
        curl_easy_setopt(easy, CURLOPT_POSTFIELDS, request.body.data());
        curl_easy_setopt(easy, CURLOPT_POSTFIELDSIZE_LARGE,
                         static_cast<curl_off_t>(request.body.size()));
    } else {
        curl_easy_setopt(easy, CURLOPT_CUSTOMREQUEST, request.method.c_str());
    }
    curl_easy_setopt(easy, CURLOPT_WRITEFUNCTION, take_body);
    curl_easy_setopt(easy, CURLOPT_WRITEDATA, &transfer);
    curl_easy_setopt(easy, CURLOPT_HEADERFUNCTION, take_header);
    curl_easy_setopt(easy, CURLOPT_HEADERDATA, &transfer);
}

CURLcode HttpClient::State::perform() {
    struct Attached {
        CURLM* multi;
        CURL* easy;
        Attached(CURLM* m, CURL* e) : multi(m), easy(e) { curl_multi_add_handle(m, e); }
        ~Attached() { curl_multi_remove_handle(multi, easy); }
    } attached(multi, easy);
    for (int running = 1; running != 0;) {
        if (curl_multi_perform(multi, &running) != CURLM_OK) return CURLE_FAILED_INIT;
        if (running == 0) break;
        if (stop()) throw Cancelled();
        curl_multi_poll(multi, nullptr, 0, kPollMs, nullptr);
    }
    int left = 0;
    while (const CURLMsg* message = curl_multi_info_read(multi, &left))
        if (message->msg == CURLMSG_DONE) return message->data.result;
    return CURLE_FAILED_INIT;
}

HttpAnswer HttpClient::send(const HttpRequest& request) {
    Transfer transfer;
    transfer.answer_bytes_max = request.answer_bytes_max;
    struct Headers {
        curl_slist* list = nullptr;
        ~Headers() { curl_slist_free_all(list); }
    } headers;
    headers.list =
        curl_slist_append(headers.list, ("Content-Type: " + request.content_type).c_str());
    headers.list = curl_slist_append(headers.list, "Expect:");  // no round trip before the body
    state_->prepare(request, headers.list, transfer);
    const CURLcode code = state_->perform();
    if (transfer.too_long)
        throw Failure(Exit::failed, "answer_too_long",
                      "the answer to " + request.method + " " + request.url + " is over " +
                          std::to_string(request.answer_bytes_max) + " bytes");
    if (code != CURLE_OK)
        throw Failure(Exit::unreachable, "unreachable",
                      "no answer from " + request.url + ": " + curl_easy_strerror(code));
    curl_easy_getinfo(state_->easy, CURLINFO_RESPONSE_CODE, &transfer.answer.status);
    return std::move(transfer.answer);
}

}  // namespace kiln::client
