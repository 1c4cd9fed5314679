// SPDX-License-Identifier: Apache-2.0
#include "server/http/request_head.h"

#include <algorithm>
#include <charconv>

#include "server/base/error.h"
#include "server/http/bounds.h"

namespace kiln {

namespace {

[[noreturn]] void refuse(const char* code, const std::string& detail) { throw Error(code, detail); }

bool is_token_character(char c) {  // RFC 9110 5.6.2
    if ((c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z')) return true;
    return std::string_view("!#$%&'*+-.^_`|~").find(c) != std::string_view::npos;
}

bool is_token(std::string_view text) {
    return !text.empty() && std::all_of(text.begin(), text.end(), is_token_character);
}

std::string lower(std::string_view text) {
    std::string out(text);
    for (char& c : out)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    return out;
}

std::string_view trimmed(std::string_view text) {
    while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
    while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
    return text;
}

int hex_value(char c) {
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    if (c >= 'A' && c <= 'F') return c - 'A' + 10;
    return -1;
}

std::string decoded(std::string_view text) {
    std::string out;
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (text[i] == '+') {
            out += ' ';
            continue;
        }
        if (text[i] != '%') {
            out += text[i];
            continue;
        }
        const int high = i + 2 < text.size() ? hex_value(text[i + 1]) : -1;
        const int low = high >= 0 ? hex_value(text[i + 2]) : -1;
        if (low < 0) refuse("bad_query", "the query has a % that two hex digits do not follow");
        const char byte = static_cast<char>(high * 16 + low);
        if (byte >= 0 && (byte < 0x20 || byte == 0x7f))
            refuse("bad_query", "the query has a control character");
        out += byte;
        i += 2;
    }
    return out;
}

void read_query(std::string_view text, HttpRequest& request) {
    while (!text.empty()) {
        const std::size_t end = std::min(text.find('&'), text.size());
        const std::string_view pair = text.substr(0, end);
        text.remove_prefix(std::min(end + 1, text.size()));
        if (pair.empty()) continue;
        const std::size_t equals = std::min(pair.find('='), pair.size());
        const std::string name = decoded(pair.substr(0, equals));
        const std::string value = decoded(pair.substr(std::min(equals + 1, pair.size())));
        if (!request.query.emplace(name, value).second)
            refuse("bad_query", "the query names a parameter twice");
    }
}

void read_target(std::string_view target, HttpRequest& request) {
    if (target.size() > kTargetBytesMax)
        refuse("uri_too_long",
               "an address has at most " + std::to_string(kTargetBytesMax) + " bytes");
    if (target.empty() || target.front() != '/')
        refuse("bad_request", "the address must start with /");
    for (const char c : target)
        if (c <= 0x20 || c >= 0x7f || c == '#')
            refuse("bad_request", "the address has a character that must be percent-encoded");
    const std::size_t question = std::min(target.find('?'), target.size());
    request.path = target.substr(0, question);
    if (request.path.size() > kPathBytesMax)
        refuse("uri_too_long", "a path has at most " + std::to_string(kPathBytesMax) + " bytes");
    read_query(target.substr(std::min(question + 1, target.size())), request);
}

/// Returns the minor version of HTTP/1.
int read_request_line(std::string_view line, HttpRequest& request) {
    const std::size_t first = line.find(' ');
    const std::size_t second = first == line.npos ? line.npos : line.find(' ', first + 1);
    if (second == line.npos || line.find(' ', second + 1) != line.npos)
        refuse("bad_request", "the request line is not METHOD /path HTTP/1.1");
    const std::string_view method = line.substr(0, first), version = line.substr(second + 1);
    if (!is_token(method) || method.size() > 16)
        refuse("bad_request", "the method is not a word of at most 16 letters");
    if (version.substr(0, 5) != "HTTP/") refuse("bad_request", "the request line has no version");
    if (version != "HTTP/1.1" && version != "HTTP/1.0")
        refuse("bad_version", "this server speaks HTTP/1.1 and HTTP/1.0");
    request.method = method;
    read_target(line.substr(first + 1, second - first - 1), request);
    return version.back() - '0';
}

/// Fields whose repetition readers resolve differently.
bool may_repeat(std::string_view name) {
    for (const std::string_view once :
         {"content-length", "content-type", "content-encoding", "transfer-encoding", "host",
          "range", "if-none-match", "if-range", "expect", "connection", "authorization"})
        if (name == once) return false;
    return true;
}

void read_field(std::string_view line, HttpRequest& request) {
    const std::size_t colon = line.find(':');
    if (colon == line.npos || !is_token(line.substr(0, colon)))
        refuse("bad_request", "a header line is not Name: value");
    const std::string name = lower(line.substr(0, colon));
    const std::string_view value = trimmed(line.substr(colon + 1));
    for (const char c : value)
        if ((c >= 0 && c < 0x20 && c != '\t') || c == 0x7f)
            refuse("bad_request", "a header value has a control character");
    const auto [entry, fresh] = request.headers.emplace(name, value);
    if (fresh) return;
    if (!may_repeat(name)) refuse("bad_request", "the header " + name + " stands twice");
    entry->second += ", " + std::string(value);
}

void read_framing(RequestHead& head) {
    const HttpRequest& request = head.request;
    const bool carries_body =
        request.method == "POST" || request.method == "PUT" || request.method == "PATCH";
    if (request.header("transfer-encoding"))
        refuse("length_required", "send the body with Content-Length, not chunked");
    const auto encoding = request.header("content-encoding");
    if (encoding && lower(*encoding) != "identity")
        refuse("wrong_type", "send the body unencoded, not with Content-Encoding");
    const auto length = request.header("content-length");
    if (length) {
        const bool digits =
            !length->empty() && std::all_of(length->begin(), length->end(),
                                            [](char c) { return c >= '0' && c <= '9'; });
        const char* end = length->data() + length->size();
        if (!digits || std::from_chars(length->data(), end, head.content_length).ec != std::errc())
            refuse("bad_request", "Content-Length is not a number of bytes");
        if (head.content_length > 0 && !carries_body)
            refuse("bad_request", "a " + request.method + " request has no body");
    } else if (carries_body) {
        refuse("length_required", "the request has no Content-Length");
    }
    if (const auto expect = request.header("expect")) {
        if (lower(*expect) != "100-continue")
            refuse("bad_expectation", "only Expect: 100-continue is understood");
        head.expects_continue = head.content_length > 0;
    }
}

}  // namespace

RequestHead parse_head(std::string_view text) {
    if (text.size() > kHeadBytesMax)
        refuse("headers_too_large",
               "a request head has at most " + std::to_string(kHeadBytesMax) + " bytes");
    if (text.size() < 4 || text.substr(text.size() - 4) != "\r\n\r\n")
        refuse("bad_request", "the request head does not end with an empty line");
    text.remove_suffix(2);
    RequestHead head;
    int minor = 0;
    for (std::size_t line_number = 0; !text.empty(); ++line_number) {
        const std::size_t end = text.find("\r\n");
        const std::string_view line = text.substr(0, end);
        text.remove_prefix(end + 2);
        if (line.find_first_of("\r\n") != line.npos || line.find('\0') != line.npos)
            refuse("bad_request", "a line of the request head does not end with CR LF");
        if (line_number > kHeadLinesMax)
            refuse("headers_too_large",
                   "a request head has at most " + std::to_string(kHeadLinesMax) + " lines");
        if (line_number == 0)
            minor = read_request_line(line, head.request);
        else
            read_field(line, head.request);
    }
    if (minor == 1 && !head.request.header("host"))
        refuse("bad_request", "the request has no Host header");
    read_framing(head);
    const std::string connection = lower(head.request.header("connection").value_or(""));
    head.request.keep_alive =
        minor == 1 ? connection.find("close") == connection.npos : connection == "keep-alive";
    return head;
}

}  // namespace kiln
