// SPDX-License-Identifier: Apache-2.0
#include "server/spec/axis_value.h"

#include <algorithm>
#include <cmath>

namespace kiln {

namespace {

/// The value at the share t of the axis.
double value_at(const Axis& axis, double t) {
    switch (axis.mapping) {
        case Mapping::linear:
            return axis.lo + (axis.hi - axis.lo) * t;
        case Mapping::sqrt: {
            const double root = std::sqrt(axis.lo) + (std::sqrt(axis.hi) - std::sqrt(axis.lo)) * t;
            return root * root;
        }
        case Mapping::square:
            return std::sqrt(axis.lo * axis.lo + (axis.hi * axis.hi - axis.lo * axis.lo) * t);
    }
    __builtin_unreachable();
}

/// Between two slices of a list: linear from one to the next, and level beyond the ends.
double listed_value(const std::vector<double>& values, double slice) {
    const auto last = static_cast<double>(values.size() - 1);
    const double held = std::clamp(slice, 0.0, last), low = std::floor(held);
    const double here = values[static_cast<std::size_t>(low)];
    const double next = values[static_cast<std::size_t>(std::min(low + 1, last))];
    return here + (next - here) * (held - low);
}

}  // namespace

double axis_value(const Axis& axis, std::int64_t index, std::int64_t count) {
    if (!axis.at.empty())
        return axis_value_between(axis, axis.at[static_cast<std::size_t>(index)], axis.of);
    return axis_value_between(axis, static_cast<double>(index), count);
}

double axis_value_between(const Axis& axis, double texel, std::int64_t count) {
    if (!axis.values.empty()) return listed_value(axis.values, texel);
    const double n = static_cast<double>(count);
    double t = axis.grid == Grid::center ? (texel + 0.5) / n : (count > 1 ? texel / (n - 1) : 0.0);
    if (axis.flip) t = 1 - t;
    t += axis.shift / n;
    return std::clamp(value_at(axis, t), axis.least, axis.most);
}

double mapped(const Axis& axis, double value) {
    switch (axis.mapping) {
        case Mapping::linear:
            return value;
        case Mapping::sqrt:
            return std::sqrt(value);
        case Mapping::square:
            return value * value;
    }
    __builtin_unreachable();
}

}  // namespace kiln
