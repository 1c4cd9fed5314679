// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <string>
#include <vector>

namespace kiln {

/// A baked table: one plane of width × height floats a channel, row 0 first.
struct Table {
    std::size_t width = 0;
    std::size_t height = 0;
    std::vector<std::string> channels;       ///< quantity names, in the job's order
    std::vector<std::vector<float>> planes;  ///< planes[channel][row * width + column]
};

}  // namespace kiln
