// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>

#include "server/spec/job_spec.h"

namespace kiln {

/// Where texel `index` of `count` lies on an axis: the parameter's value. Centres lie at (i + ½) /
/// n of the axis, nodes at i / (n − 1) (a single node at 0), listed values where the list says. The
/// one place that knows grid, mapping and flip.
double axis_value(const Axis& axis, std::int64_t index, std::int64_t count);
/// The same between texels: lookup at this distance, in texels, from
/// the first one.
double axis_value_between(const Axis& axis, double texel, std::int64_t count);

/// alpha = roughness². The one place that knows the mapping.
inline double alpha_from_roughness(double roughness) { return roughness * roughness; }

/// What an axis is linear in: the parameter under its mapping.
double mapped(const Axis& axis, double value);

}  // namespace kiln
