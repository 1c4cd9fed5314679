// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <bit>
#include <cmath>
#include <cstdint>

// The kernels at one lane, in double and in float: ordinary functions to hold against textbook
// forms.

namespace in_double {
using scalar = double;
using real = double;
inline real lane_sqrt(real x) { return std::sqrt(x); }
inline real lane_fma(real a, real b, real c) { return std::fma(a, b, c); }
#define KILN_AS_BITS(x) std::bit_cast<std::int64_t>(x)
#define KILN_AS_REAL(x) std::bit_cast<double>(x)
#define KILN_DOUBLE 1
#define KILN_LANES 1
#include "kernels/kernels.h"
#undef KILN_DOUBLE
#undef KILN_LANES
}  // namespace in_double

namespace in_float {
using scalar = float;
using real = float;
inline real lane_sqrt(real x) { return std::sqrt(x); }
inline real lane_fma(real a, real b, real c) { return std::fma(a, b, c); }
#undef KILN_AS_BITS
#undef KILN_AS_REAL
#define KILN_AS_BITS(x) std::bit_cast<std::int32_t>(x)
#define KILN_AS_REAL(x) std::bit_cast<float>(x)
#define KILN_DOUBLE 0
#define KILN_LANES 1
#include "kernels/kernels.h"
#undef KILN_DOUBLE
#undef KILN_LANES
}  // namespace in_float
