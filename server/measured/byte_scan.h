// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

#include "server/base/error.h"

namespace kiln::measured {

static_assert(std::endian::native == std::endian::little, "binary files are little endian");

/// Throws Error("malformed_measurement", "byte N: …").
[[noreturn]] inline void fail_at_byte(std::uint64_t offset, const std::string& what) {
    throw Error("malformed_measurement", "byte " + std::to_string(offset) + ": " + what);
}

/// The little-endian value at an offset. Throws where the file ends before it does.
template <typename T>
T load(std::string_view bytes, std::uint64_t offset) {
    if (offset > bytes.size() || bytes.size() - offset < sizeof(T))
        fail_at_byte(bytes.size(), "the file ends within a value of " + std::to_string(sizeof(T)) +
                                       " bytes at byte " + std::to_string(offset));
    T value;
    std::memcpy(&value, bytes.data() + offset, sizeof value);
    return value;
}

}  // namespace kiln::measured
