// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstdint>

namespace kiln {

/// RGB9_E5 as Khronos (EXT_texture_shared_exponent) defines it: three mantissas of nine bits, red
/// in the lowest, and an exponent in the highest five: c = mantissa * 2^(exponent - 24).
/// Negative values and NaN become 0; what is larger than kRgb9e5Most becomes that.
std::uint32_t to_rgb9e5(const std::array<double, 3>& c);
std::array<double, 3> from_rgb9e5(std::uint32_t bits);

inline constexpr double kRgb9e5Most = 65408;  ///< (2^9 - 1) / 2^9 * 2^16

}  // namespace kiln
