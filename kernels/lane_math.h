// SPDX-License-Identifier: Apache-2.0
// Elementary functions from + − × ÷ √ and lane_fma alone: the same bits on every device, which no
// C library promises. The polynomials are minimax fits (Remez), each with its error beside it.
// A NaN comes out as a NaN. Nothing here returns a subnormal, and no argument but a zero may be
// one: some devices have none.

// The largest scalar, the smallest normal one, one with a square well above it, and the logarithm
// past the largest.
#undef KILN_HUGE
#undef KILN_TINY
#undef KILN_ROOT_TINY
#undef KILN_EXPONENT_MAX
#if KILN_DOUBLE
#define KILN_HUGE K(1.7976931348623157e308)
#define KILN_TINY K(2.2250738585072014e-308)
#define KILN_ROOT_TINY K(1e-150)
#define KILN_EXPONENT_MAX K(1024.0)
#else
#define KILN_HUGE K(3.402823466e38)
#define KILN_TINY K(1.175494351e-38)
#define KILN_ROOT_TINY K(1e-18)
#define KILN_EXPONENT_MAX K(128.0)
#endif

// Where one argument of these may be a NaN, it is the first.
KILN_FUNCTION real lane_min(real a, real b) { return lane_select(a > b, b, a); }
KILN_FUNCTION real lane_max(real a, real b) { return lane_select(a < b, b, a); }
KILN_FUNCTION real lane_abs(real x) { return lane_select(x < K(0.0), -x, x); }
KILN_FUNCTION real lane_saturate(real x) {
    return lane_max(lane_min(x, lanes(K(1.0))), lanes(K(0.0)));
}

// An unevaluated sum, |lo| ≲ ulp(hi).
typedef struct {
    real hi, lo;
} RealPair;

// 2^(hi + lo): 0 below −125 (−1021), ∞ from 128 (1024). Adding 1.5 · 2^23 (2^52) rounds to an
// integer and leaves it in the low bits, ready to be an exponent of a bias one less than usual:
// 2^128 · p may be finite where 2^128 is not. What is out of range becomes −126 or 129 before, of
// which those bits make 0 and ∞ themselves: no lane computes what nobody chooses, and no flag of
// IEEE 754 says what is not so. A hi that is a NaN stays one.
KILN_FUNCTION real lane_exp2_pair(RealPair x) {
#if KILN_DOUBLE
    const real rounder = lanes(K(6755399441056766.0));  // 1.5 · 2^52 + 1022
#else
    const real rounder = lanes(K(12583038.0));  // 1.5 · 2^23 + 126
#endif
    const real most = lanes(KILN_EXPONENT_MAX + K(1.0)), least = K(3.0) - most;
    real hi = lane_select(x.hi >= KILN_EXPONENT_MAX, most, x.hi);
    hi = lane_select(hi < K(3.0) - KILN_EXPONENT_MAX, least, hi);
    const real lo = lane_select(hi == x.hi, x.lo, lanes(K(0.0)));
    const real biased = hi + rounder;
    const real r = (hi - (biased - rounder)) + lo;  // |r| ≤ 1/2
    // (2^r − 1) / r, to 2^-52 / 72 of 2^r in double, 2^-23 / 32 in float.
#if KILN_DOUBLE
    real p = lanes(K(4.4566754636398607237e-10));
    p = lane_fma(p, r, lanes(K(7.0725864798520196266e-9)));
    p = lane_fma(p, r, lanes(K(1.0178051728089911537e-7)));
    p = lane_fma(p, r, lanes(K(1.3215442584937202908e-6)));
    p = lane_fma(p, r, lanes(K(0.000015252733853280778418)));
    p = lane_fma(p, r, lanes(K(0.00015403530441741645964)));
    p = lane_fma(p, r, lanes(K(0.0013333558146396003091)));
    p = lane_fma(p, r, lanes(K(0.0096181291076068846414)));
    p = lane_fma(p, r, lanes(K(0.05550410866482165975)));
    p = lane_fma(p, r, lanes(K(0.24022650695910098227)));
    p = lane_fma(p, r, lanes(K(0.69314718055994530909)));
#else
    real p = lanes(K(0.0001546973198));
    p = lane_fma(p, r, lanes(K(0.001339087134)));
    p = lane_fma(p, r, lanes(K(0.009618030783)));
    p = lane_fma(p, r, lanes(K(0.05550357094)));
    p = lane_fma(p, r, lanes(K(0.2402265108)));
    p = lane_fma(p, r, lanes(K(0.693147188)));
#endif
#if KILN_DOUBLE
    const real scale = KILN_AS_REAL(KILN_AS_BITS(biased) << 52);
#else
    const real scale = KILN_AS_REAL(KILN_AS_BITS(biased) << 23);
#endif
    return K(2.0) * (lane_fma(p, r, lanes(K(1.0))) * scale);
}

KILN_CALLED real lane_exp2(real x) {
    const RealPair exponent = {x, lanes(K(0.0))};
    return lane_exp2_pair(exponent);
}

// factor · log2 e of a factor in two parts; log2 e itself is in two parts.
KILN_FUNCTION RealPair lane_times_log2e(real factor, real rest) {
#if KILN_DOUBLE
    const real log2e = lanes(K(1.4426950408889634)), log2e_rest = lanes(K(2.0355273740931033e-17));
#else
    const real log2e = lanes(K(1.44269502)), log2e_rest = lanes(K(1.925963033e-8));
#endif
    RealPair product;
    product.hi = factor * log2e;
    product.lo = lane_fma(factor, log2e, -product.hi) + lane_fma(rest, log2e, factor * log2e_rest);
    return product;
}

// 0 below −86.6 (−707.7), ∞ from 88.7 (709.8).
KILN_CALLED real lane_exp(real x) { return lane_exp2_pair(lane_times_log2e(x, lanes(K(0.0)))); }

// exp(−x²), with the rounding of the square put right: of x² = 80, half an ulp is 4e-6.
KILN_CALLED real lane_exp_minus_square(real x) {
    const real square = x * x;
    return lane_exp2_pair(lane_times_log2e(-square, -lane_fma(x, x, -square)));
}

// log2 x of x ≥ 0, finite, to 2^-29 (2^-58) relative; of 0 it is −KILN_HUGE, so that 0 · log2 0 is
// no NaN. With x = 2^e m, √½ ≤ m ≤ √2, and s = (m − 1) / (m + 1): log2 m = (2 / ln 2) atanh s.
KILN_FUNCTION RealPair lane_log2_pair(real x) {
#if KILN_DOUBLE
    const real field =  // e + 1023
        KILN_AS_REAL(((KILN_AS_BITS(x) >> 52) & 0x7FF) | 0x4330000000000000) -
        K(4503599627370496.0);
    const real significand = KILN_AS_REAL((KILN_AS_BITS(x) & 0xFFFFFFFFFFFFF) | 0x3FF0000000000000);
    const real bias = lanes(K(1023.0));
    const real two_log2e = lanes(K(2.8853900817779268)), rest = lanes(K(4.0710547481862066e-17));
#else
    const real field =  // e + 127
        KILN_AS_REAL(((KILN_AS_BITS(x) >> 23) & 0xFF) | 0x4B000000) - K(8388608.0);
    const real significand = KILN_AS_REAL((KILN_AS_BITS(x) & 0x7FFFFF) | 0x3F800000);
    const real bias = lanes(K(127.0));
    const real two_log2e = lanes(K(2.88539004)), rest = lanes(K(3.851926067e-8));
#endif
    const real m = lane_select(significand > K(1.4142135), K(0.5) * significand, significand);
    const real e = lane_select(significand > K(1.4142135), field + K(1.0), field) - bias;
    const real above = m - K(1.0), sum = m + K(1.0);
    const real sum_rest = m - (sum - K(1.0));
    const real inverse = K(1.0) / sum;
    const real s = above * inverse;
    const real s_rest = inverse * lane_fma(-s, sum_rest, lane_fma(-s, sum, above));
    const real z = s * s;
    // (2 / ln 2) (atanh s − s) / s³, to 2^-64 of log2 m in double, 2^-35 in float.
#if KILN_DOUBLE
    real p = lanes(K(0.18881919161038290826));
    p = lane_fma(p, z, lanes(K(0.19142598143462742806)));
    p = lane_fma(p, z, lanes(K(0.22197659548276727478)));
    p = lane_fma(p, z, lanes(K(0.26230786248606290679)));
    p = lane_fma(p, z, lanes(K(0.32059890043649594843)));
    p = lane_fma(p, z, lanes(K(0.41219858310203870841)));
    p = lane_fma(p, z, lanes(K(0.57707801635559815629)));
    p = lane_fma(p, z, lanes(K(0.96179669392597560195)));
#else
    real p = lanes(K(0.3366151303));
    p = lane_fma(p, z, lanes(K(0.4119000691)));
    p = lane_fma(p, z, lanes(K(0.5770797873)));
    p = lane_fma(p, z, lanes(K(0.9617966923)));
#endif
    const real product = two_log2e * s;
    const real product_rest =  // atanh' s ≈ 1 + s²
        lane_fma(two_log2e, s, -product) + two_log2e * lane_fma(s_rest, z, s_rest);
    const real tail = lane_fma(s * z, p, lane_fma(rest, s, product_rest));
    const real fraction = product + tail;
    const real fraction_rest = (product - fraction) + tail;
    RealPair log2;
    log2.hi = e + fraction;
    log2.lo = lane_select(x < KILN_TINY, lanes(K(0.0)), ((e - log2.hi) + fraction) + fraction_rest);
    log2.hi = lane_select(x <= KILN_HUGE, log2.hi, x);
    log2.hi = lane_select(x < KILN_TINY, lanes(-KILN_HUGE), log2.hi);
    return log2;
}

KILN_CALLED real lane_log2(real x) {
    const RealPair log2 = lane_log2_pair(x);
    return log2.hi + log2.lo;
}

// x^y of finite x ≥ 0: 0^y is 0 for y > 0, 1 for y = 0, ∞ for y < 0, of which y's sign is enough:
// y · log2 0 would overflow beyond 1.
KILN_CALLED real lane_pow(real x, real y) {
    const RealPair log2 = lane_log2_pair(x);
    const real one = lanes(K(1.0));
    y = lane_select(x < KILN_TINY, lane_max(lane_min(y, one), -one), y);
    RealPair exponent;
    exponent.hi = y * log2.hi;
    exponent.lo = lane_fma(y, log2.lo, lane_fma(y, log2.hi, -exponent.hi));
    return lane_exp2_pair(exponent);
}

// (1 − x)^y of x in [0, 1] and y > 0, as lane_pow(), with what 1 − x loses to rounding put right:
// of a large y it is felt.
KILN_CALLED real lane_pow_one_minus(real x, real y) {
    const real m = K(1.0) - x, lost = (K(1.0) - m) - x;
    const real base = lane_select(m > K(0.0), m, lanes(K(1.0)));
    const RealPair log2 = lane_log2_pair(base);
    const real lo = lane_fma(lost / base, lanes(K(1.4426950408889634)), log2.lo);
    const real hi = y * log2.hi, rest = lane_fma(y, lo, lane_fma(y, log2.hi, -hi));
    RealPair exponent;
    exponent.hi = hi + rest;
    exponent.lo = rest - (exponent.hi - hi);
    return lane_select(m > K(0.0), lane_exp2_pair(exponent), lanes(K(0.0)));
}
