// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <bit>
#include <cmath>
#include <cstdint>

// The kernels on the host, one sample at a time in double: for what is needed once, by the very
// formulas that the tables are made of. √, ÷ and the fused product are correctly rounded, so they
// are the same on every machine.

namespace kiln::one_lane {
using scalar = double;
using real = double;
inline real lane_sqrt(real x) { return std::sqrt(x); }
inline real lane_fma(real a, real b, real c) { return std::fma(a, b, c); }
#define KILN_DOUBLE 1
#define KILN_LANES 1
#define KILN_AS_BITS(x) std::bit_cast<std::int64_t>(x)
#define KILN_AS_REAL(x) std::bit_cast<double>(x)
#include "kernels/kernels.h"
#undef KILN_DOUBLE
#undef KILN_LANES
#undef KILN_AS_BITS
#undef KILN_AS_REAL
}  // namespace kiln::one_lane
