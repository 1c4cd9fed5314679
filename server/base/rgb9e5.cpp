// SPDX-License-Identifier: Apache-2.0
#include "server/base/rgb9e5.h"

#include <algorithm>
#include <cmath>

namespace kiln {

std::uint32_t to_rgb9e5(const std::array<double, 3>& c) {
    std::array<double, 3> held{};
    for (std::size_t k = 0; k < 3; ++k) held[k] = c[k] > 0 ? std::min(c[k], kRgb9e5Most) : 0.0;
    const double most = *std::max_element(held.begin(), held.end());
    int exponent = most > 0 ? std::max(-16, std::ilogb(most)) + 16 : 0;
    // Rounding may carry the largest mantissa to 2^9: one exponent up.
    if (std::floor(std::ldexp(most, 24 - exponent) + 0.5) >= 512) ++exponent;
    std::uint32_t bits = static_cast<std::uint32_t>(exponent) << 27;
    for (std::size_t k = 0; k < 3; ++k)
        bits |= static_cast<std::uint32_t>(std::floor(std::ldexp(held[k], 24 - exponent) + 0.5))
                << (9 * k);
    return bits;
}

std::array<double, 3> from_rgb9e5(std::uint32_t bits) {
    const int exponent = static_cast<int>(bits >> 27);
    std::array<double, 3> c{};
    for (std::size_t k = 0; k < 3; ++k)
        c[k] = std::ldexp(static_cast<double>(bits >> (9 * k) & 511), exponent - 24);
    return c;
}

}  // namespace kiln
