// SPDX-License-Identifier: Apache-2.0
#include "benchmarks/arithmetic_limit.h"

#include <immintrin.h>

namespace kiln {

namespace {

// Products stand for all operations: none takes less of the multipliers. Every result goes to a
// register that nobody reads, so that they overlap as the CPU likes.
template <int operations>
__attribute__((target("avx2,fma"))) void run_v3(long samples) {
    const __m256 x = _mm256_set1_ps(1.25F);
    for (long i = 0; i < samples; ++i)
        asm volatile(
            "vsqrtps %0, %%ymm14\n\t"
            "vdivps %0, %0, %%ymm15\n\t"
            ".rept %c1\n\tvmulps %0, %0, %%ymm13\n\t.endr"
            :
            : "x"(x), "i"(operations)
            : "xmm13", "xmm14", "xmm15");
}

template <int operations>
__attribute__((target("avx512f"))) void run_v4(long samples) {
    const __m512 x = _mm512_set1_ps(1.25F);
    for (long i = 0; i < samples; ++i)
        asm volatile(
            "vsqrtps %0, %%zmm14\n\t"
            "vdivps %0, %0, %%zmm15\n\t"
            ".rept %c1\n\tvmulps %0, %0, %%zmm13\n\t.endr"
            :
            : "v"(x), "i"(operations)
            : "xmm13", "xmm14", "xmm15");
}

template <int operations>
std::size_t run(InstructionSet set, long samples) {
    switch (set) {
        case InstructionSet::v2:
            return 0;
        case InstructionSet::v3:
            run_v3<operations>(samples);
            return 8;
        case InstructionSet::v4:
            run_v4<operations>(samples);
            return 16;
    }
    __builtin_unreachable();
}

}  // namespace

std::size_t run_arithmetic_alone(InstructionSet set, HandCount count, long samples) {
    return count.operations == kCountE.operations ? run<kCountE.operations>(set, samples)
                                                  : run<kCountAB.operations>(set, samples);
}

}  // namespace kiln
