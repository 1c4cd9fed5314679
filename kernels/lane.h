// SPDX-License-Identifier: Apache-2.0
// The dialect: what OpenCL C and C++ do not spell alike, and nothing else. Every other file of this
// folder is C that both languages read. Meant to be included again under other settings (no guard):
//   KILN_DOUBLE  0 | 1    precision of scalar and real
//   KILN_LANES   1 | 2 …  lanes of a real: one on GPUs, a SIMD register or more on CPUs
// Two kinds of value: `scalar` is uniform, `real` is one value a lane. A real is never tested by
// `if`; lane_select(condition, a, b) is its choice, of which both sides are computed: what divides
// is made safe before, and where the numerator is constant in a variable of its own, since GCC
// takes K(1.0) / lane_select(…) apart and divides by what was not chosen. Only + − × ÷ √ and
// lane_fma, all correctly rounded, reach a real, and contraction is off: which products are fused
// stands in the text, so that every CPU gives the same bits. (A CPU without the instruction,
// x86-64-v2 and older, computes lane_fma in software, slowly.)

#ifdef __OPENCL_C_VERSION__

#pragma OPENCL FP_CONTRACT OFF
#define KILN_FUNCTION static inline
// For what would go through memory if it were called: wide vectors by address.
#define KILN_INLINED __attribute__((always_inline)) static inline
#define KILN_CALLED static inline
#define KILN_GLOBAL __global
#define KILN_ROLLED _Pragma("unroll 1")
#define lane_select(condition, a, b) ((condition) ? (a) : (b))
#define KILN_JOIN_(type, lanes) type##lanes
#define KILN_JOIN(type, lanes) KILN_JOIN_(type, lanes)
#if KILN_DOUBLE
#pragma OPENCL EXTENSION cl_khr_fp64 : enable
typedef double scalar;
#else
typedef float scalar;
#endif
#if KILN_LANES == 1
typedef scalar real;
#elif KILN_DOUBLE
typedef KILN_JOIN(double, KILN_LANES) real;
#else
typedef KILN_JOIN(float, KILN_LANES) real;
#endif
KILN_FUNCTION real lane_sqrt(real x) { return sqrt(x); }
KILN_FUNCTION real lane_fma(real a, real b, real c) { return fma(a, b, c); }
KILN_FUNCTION real lanes(scalar x) { return (real)(x); }
KILN_FUNCTION real lane_gather(__global const scalar* table, real index) {
#if KILN_LANES == 1
    return table[(int)index];
#else
    real value;
    for (int lane = 0; lane < KILN_LANES; ++lane)
        ((scalar*)&value)[lane] = table[(int)((scalar*)&index)[lane]];
    return value;
#endif
}
#if KILN_DOUBLE && KILN_LANES == 1
#define KILN_AS_BITS(x) as_long(x)
#define KILN_AS_REAL(x) as_double(x)
#elif KILN_DOUBLE
#define KILN_AS_BITS(x) KILN_JOIN(as_long, KILN_LANES)(x)
#define KILN_AS_REAL(x) KILN_JOIN(as_double, KILN_LANES)(x)
#elif KILN_LANES == 1
#define KILN_AS_BITS(x) as_int(x)
#define KILN_AS_REAL(x) as_float(x)
#else
#define KILN_AS_BITS(x) KILN_JOIN(as_int, KILN_LANES)(x)
#define KILN_AS_REAL(x) KILN_JOIN(as_float, KILN_LANES)(x)
#endif

#else  // C++: whoever includes this has defined scalar, real, lane_sqrt, lane_fma and the casts of
       // bits

#define KILN_FUNCTION __attribute__((always_inline)) static inline
#define KILN_INLINED KILN_FUNCTION
// For what is long and stands in many places: one copy, called, compiles in a tenth of the time.
#define KILN_CALLED __attribute__((noinline, unused)) static
#define KILN_GLOBAL
// Before a loop that must not be unrolled, for what that would cost to compile.
#define KILN_ROLLED _Pragma("GCC unroll 1")
#ifndef lane_select
#define lane_select(condition, a, b) ((condition) ? (a) : (b))
#endif
KILN_FUNCTION real lanes(scalar x) { return x - real{}; }
// table[index] a lane; the index is a whole number.
KILN_FUNCTION real lane_gather(const scalar* table, real index) {
#if KILN_LANES == 1
    return table[(int)index];
#else
    real value = index;
    for (int lane = 0; lane < KILN_LANES; ++lane) value[lane] = table[(int)index[lane]];
    return value;
#endif
}

#endif

// A literal in the precision of scalar: a bare 0.5 would turn float arithmetic into double.
#ifdef K
#undef K
#endif
#if KILN_DOUBLE
#define K(literal) literal
#else
#define K(literal) literal##f
#endif
#define KILN_PI K(3.14159265358979324)

// 1/√x and √x on the multipliers, which are idle while the divider serves a √ or ÷ beside them; on
// every device the same bits. y = the guess that halves the exponent is up to 6 % off (Lomont
// 2003); e = 1 − x y² in [.0076, .125] says by how much, and 1/√x = y (1 − e)^(−1/2) by the
// polynomial whose greatest relative error there is the least.
#if !KILN_DOUBLE
KILN_FUNCTION real lane_rsqrt_guess(real x) {
    return KILN_AS_REAL(0x5F300000 - (KILN_AS_BITS(x) >> 1));
}
#endif

// For normal x > 0, to 7e-7 of 1/√x in float: itself, and a / √x + b by a shorter chain.
#if KILN_DOUBLE
KILN_FUNCTION real lane_rsqrt(real x) { return K(1.0) / lane_sqrt(x); }
KILN_FUNCTION real lane_fma_rsqrt(real a, real x, real b) { return lane_fma(a, lane_rsqrt(x), b); }
#else
KILN_FUNCTION real lane_rsqrt_over_guess(real x, real y) {
    const real e = lane_fma(-(x * y), y, lanes(K(1.0)));
    real p = lane_fma(lanes(K(0.398867996)), e, lanes(K(0.367107121)));
    p = lane_fma(p, e, lanes(K(0.500250726)));
    return lane_fma(p, e, lanes(K(0.999997966)));
}
KILN_FUNCTION real lane_rsqrt(real x) {
    const real y = lane_rsqrt_guess(x);
    return y * lane_rsqrt_over_guess(x, y);
}
KILN_FUNCTION real lane_fma_rsqrt(real a, real x, real b) {
    const real y = lane_rsqrt_guess(x);
    return lane_fma(a * y, lane_rsqrt_over_guess(x, y), b);
}
#endif

// For normal x > 0 and 0, to 1.8e-7 relative in float.
KILN_FUNCTION real lane_root(real x) {
#if KILN_DOUBLE
    return lane_sqrt(x);
#else
    const real y = lane_rsqrt_guess(x), root = x * y;
    const real e = lane_fma(-root, y, lanes(K(1.0)));
    real p = lane_fma(lanes(K(0.374183630)), e, lanes(K(0.299621110)));
    p = lane_fma(p, e, lanes(K(0.375690831)));
    p = lane_fma(p, e, lanes(K(0.499985096)));
    return root * lane_fma(p, e, lanes(K(1.000000094)));
#endif
}
