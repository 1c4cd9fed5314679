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

}  // namespace

double axis_value(const Axis& axis, std::int64_t index, std::int64_t count) {
    if (!axis.values.empty()) return axis.values[static_cast<std::size_t>(index)];
    if (!axis.at.empty())
        return axis_value_between(axis, axis.at[static_cast<std::size_t>(index)], axis.of);
    return axis_value_between(axis, static_cast<double>(index), count);
}

double axis_value_between(const Axis& axis, double texel, std::int64_t count) {
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
