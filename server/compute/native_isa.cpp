// SPDX-License-Identifier: Apache-2.0
// Compiled once an instruction set, with -march=x86-64-vN, KILN_ISA = kNativeVN and
// KILN_REGISTER_BYTES. GCC's vector types carry the lanes; only √ and the fused product need an
// intrinsic.
#include <immintrin.h>

#include "server/compute/native_group.h"

namespace kiln {
namespace {

#if KILN_REGISTER_BYTES == 64
// The unmasked forms read a value that GCC 12's header leaves undefined, and warn.
__attribute__((always_inline)) inline __m512 root(__m512 x) {
    return _mm512_maskz_sqrt_ps(0xFFFF, x);
}
__attribute__((always_inline)) inline __m512 fused(__m512 a, __m512 b, __m512 c) {
    return _mm512_fmadd_ps(a, b, c);
}
__attribute__((always_inline)) inline __m512d root(__m512d x) {
    return _mm512_maskz_sqrt_pd(0xFF, x);
}
__attribute__((always_inline)) inline __m512d fused(__m512d a, __m512d b, __m512d c) {
    return _mm512_fmadd_pd(a, b, c);
}
using FloatRegister = __m512;
using DoubleRegister = __m512d;
#elif KILN_REGISTER_BYTES == 32
__attribute__((always_inline)) inline __m256 root(__m256 x) { return _mm256_sqrt_ps(x); }
__attribute__((always_inline)) inline __m256 fused(__m256 a, __m256 b, __m256 c) {
    return _mm256_fmadd_ps(a, b, c);
}
__attribute__((always_inline)) inline __m256d root(__m256d x) { return _mm256_sqrt_pd(x); }
__attribute__((always_inline)) inline __m256d fused(__m256d a, __m256d b, __m256d c) {
    return _mm256_fmadd_pd(a, b, c);
}
using FloatRegister = __m256;
using DoubleRegister = __m256d;
#else
__attribute__((always_inline)) inline __m128 root(__m128 x) { return _mm_sqrt_ps(x); }
// No instruction for it at this level: the C library's, exact and slow.
__attribute__((always_inline)) inline __m128 fused(__m128 a, __m128 b, __m128 c) {
    for (int lane = 0; lane < 4; ++lane) c[lane] = __builtin_fmaf(a[lane], b[lane], c[lane]);
    return c;
}
__attribute__((always_inline)) inline __m128d root(__m128d x) { return _mm_sqrt_pd(x); }
// No instruction for it at this level: the C library's, exact and slow.
__attribute__((always_inline)) inline __m128d fused(__m128d a, __m128d b, __m128d c) {
    for (int lane = 0; lane < 2; ++lane) c[lane] = __builtin_fma(a[lane], b[lane], c[lane]);
    return c;
}
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
__attribute__((always_inline)) inline Register register_fma(Register a, Register b, Register c) {
    return (Register)fused((FloatRegister)a, (FloatRegister)b, (FloatRegister)c);
}
#define KILN_DOUBLE 0
#define KILN_LANES (KILN_REGISTER_BYTES / 4)
#include "server/compute/native_kernels.h"
#include "server/compute/native_measured.h"
#include "server/compute/native_quadrature.h"
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
__attribute__((always_inline)) inline Register register_fma(Register a, Register b, Register c) {
    return (Register)fused((DoubleRegister)a, (DoubleRegister)b, (DoubleRegister)c);
}
#define KILN_DOUBLE 1
#define KILN_LANES (KILN_REGISTER_BYTES / 8)
#include "server/compute/native_kernels.h"
#include "server/compute/native_measured.h"
#include "server/compute/native_quadrature.h"
#undef KILN_DOUBLE
#undef KILN_LANES
}  // namespace in_double

}  // namespace

extern const NativeKernels KILN_ISA;
const NativeKernels KILN_ISA = {
    {KILN_REGISTER_BYTES / 4, in_float::find, in_float::find_quadrature, in_float::measured_values,
     in_float::measured_albedos},
    {KILN_REGISTER_BYTES / 8, in_double::find, in_double::find_quadrature,
     in_double::measured_values, in_double::measured_albedos}};

}  // namespace kiln
