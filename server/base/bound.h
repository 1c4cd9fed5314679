// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <string_view>
#include <vector>

namespace kiln {

/// A bound that no setting moves, as GET /v1/capabilities shows it. Each room lists its own in its
/// bounds.cpp; the values are the constants that hold them.
struct Bound {
    std::string_view name;
    std::uint64_t value = 0;
    std::string_view unit, description;
};

using Bounds = std::vector<Bound>;

}  // namespace kiln
