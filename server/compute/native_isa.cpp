// SPDX-License-Identifier: Apache-2.0
// Compiled once an instruction set, with -march=x86-64-vN, KILN_ISA = kNativeVN and KILN_REGISTER_BYTES.
// GCC's vector types carry the lanes; only √ needs an intrinsic.
#include <immintrin.h>

#include "server/compute/native_group.h"

namespace kiln {
namespace {

#if KILN_REGISTER_BYTES == 64
__attribute__((always_inline)) inline __m512 root(__m512 x) { return _mm512_sqrt_ps(x); }
__attribute__((always_inline)) inline __m512d root(__m512d x) { return _mm512_sqrt_pd(x); }
using FloatRegister = __m512;
using DoubleRegister = __m512d;
#elif KILN_REGISTER_BYTES == 32
__attribute__((always_inline)) inline __m256 root(__m256 x) { return _mm256_sqrt_ps(x); }
__attribute__((always_inline)) inline __m256d root(__m256d x) { return _mm256_sqrt_pd(x); }
using FloatRegister = __m256;
using DoubleRegister = __m256d;
#else
__attribute__((always_inline)) inline __m128 root(__m128 x) { return _mm_sqrt_ps(x); }
__attribute__((always_inline)) inline __m128d root(__m128d x) { return _mm_sqrt_pd(x); }
using FloatRegister = __m128;
using DoubleRegister = __m128d;
#endif

namespace in_float {
using scalar = float;
typedef float Register __attribute__((vector_size(KILN_REGISTER_BYTES)));
typedef int RegisterBits __attribute__((vector_size(KILN_REGISTER_BYTES)));
__attribute__((always_inline)) inline Register register_sqrt(Register x) {
    return (Register)root((FloatRegister)x);
}
#define KILN_DOUBLE 0
#define KILN_LANES (KILN_REGISTER_BYTES / 4)
#include "server/compute/native_kernels.h"
#undef KILN_DOUBLE
#undef KILN_LANES
}  // namespace in_float

namespace in_double {
using scalar = double;
typedef double Register __attribute__((vector_size(KILN_REGISTER_BYTES)));
typedef long RegisterBits __attribute__((vector_size(KILN_REGISTER_BYTES)));
__attribute__((always_inline)) inline Register register_sqrt(Register x) {
    return (Register)root((DoubleRegister)x);
}
#define KILN_DOUBLE 1
#define KILN_LANES (KILN_REGISTER_BYTES / 8)
#include "server/compute/native_kernels.h"
#undef KILN_DOUBLE
#undef KILN_LANES
}  // namespace in_double

}  // namespace

extern const NativeKernels KILN_ISA;
const NativeKernels KILN_ISA = {KILN_REGISTER_BYTES / 4, KILN_REGISTER_BYTES / 8, in_float::find, in_double::find};

}  // namespace kiln
