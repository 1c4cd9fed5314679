// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>

#include "server/compute/native.h"

namespace kiln {

/// What a kernel's loop computes for one sample of a lane group, as counted by hand: one √, one ÷
/// and so many products, sums, fused products and selections.
struct HandCount {
    int operations = 0;
};
inline constexpr HandCount kCountE{23}, kCountAB{38};

/// Runs `samples` times those operations on one core in registers alone, none of which waits for
/// another, nor for memory: the time that no loop with this count can go below. `count` is one of
/// the above. Returns the lanes of a group; 0 where the instruction set has no fused product to
/// count.
std::size_t run_arithmetic_alone(InstructionSet set, HandCount count, long samples);

}  // namespace kiln
