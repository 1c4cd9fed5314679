// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "server/base/error.h"
#include "server/compute/table.h"

/// Tables to encode: five quantities' names, values from a function or at random.
namespace tables {

inline const std::vector<std::string>& names() {
    static const std::vector<std::string> all = {"split_sum_scale", "split_sum_bias",
                                                 "directional_albedo", "average_albedo",
                                                 "multiscatter_albedo"};
    return all;
}

inline kiln::Table filled(
    std::size_t width, std::size_t height, std::size_t channels,
    const std::function<float(std::size_t channel, std::size_t texel)>& value) {
    kiln::Table table{.width = width, .height = height, .channels = {}, .planes = {}};
    for (std::size_t c = 0; c < channels; ++c) {
        table.channels.push_back(names().at(c));
        table.planes.emplace_back(width * height);
        for (std::size_t i = 0; i < width * height; ++i) table.planes[c][i] = value(c, i);
    }
    return table;
}

/// Uniform in [lo, hi); equal seeds give equal tables.
inline kiln::Table noise(std::size_t width, std::size_t height, std::size_t channels, float lo,
                         float hi, unsigned seed = 1) {
    std::mt19937 engine(seed);
    return filled(width, height, channels, [&](std::size_t, std::size_t) {
        return lo + (hi - lo) * static_cast<float>(engine() >> 8U) * 0x1p-24F;
    });
}

inline kiln::Table of(std::vector<float> values) {
    return filled(values.size(), 1, 1, [&](std::size_t, std::size_t i) { return values[i]; });
}

/// The code of the kiln::Error that `action` throws, "" when it throws none.
inline std::string code_of(const std::function<void()>& action) {
    try {
        action();
    } catch (const kiln::Error& e) {
        return e.code();
    }
    return "";
}

}  // namespace tables
