// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>
#include <cstdint>
#include <initializer_list>
#include <string>
#include <string_view>

#include "server/http/message.h"

namespace kiln {

/// Refuses parameters that the endpoint does not know: Error("bad_query") naming them.
void expect_only(const HttpRequest& request, std::initializer_list<std::string_view> names);

/// ?wait= in seconds, 0 when absent; Error("bad_query") outside 0…limits().wait_s_max.
std::chrono::milliseconds wait_of(const HttpRequest& request);

/// An integer parameter with its default and range.
std::int64_t integer_of(const HttpRequest& request, const std::string& name, std::int64_t fallback,
                        std::int64_t min, std::int64_t max);

/// Error("wrong_type") unless Content-Type is application/json; a client that is no browser may
/// leave it out or at curl's default.
void expect_json(const HttpRequest& request);

/// Error("wrong_type") unless Content-Type is application/octet-stream; as expect_json otherwise.
void expect_bytes(const HttpRequest& request);

/// Error("wrong_type") unless Content-Type is that of a glTF asset, JSON or bytes. No browser sends
/// one of these to a loopback port without asking first.
void expect_scene(const HttpRequest& request);

}  // namespace kiln
