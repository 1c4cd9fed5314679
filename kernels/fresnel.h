// SPDX-License-Identifier: Apache-2.0
// Fresnel terms: F(VoH) of one colour channel, from scalars that the host has prepared in double
// (fresnel_parameters() in server/compute/fresnel.h says what they are). VoH is in [0, 1], or above
// by rounding: then it counts as 1. No parameter that the host lets through makes a NaN.

#define KILN_FRESNEL_PARAMETERS 8

#define KILN_FRESNEL_NONE 0
#define KILN_FRESNEL_SCHLICK 1        // exponent 5
#define KILN_FRESNEL_SCHLICK_POWER 2  // any other exponent
#define KILN_FRESNEL_DIELECTRIC 3
#define KILN_FRESNEL_CONDUCTOR 4
#define KILN_FRESNEL_F82_TINT 5

KILN_FUNCTION real fresnel_one_minus(real VoH) {
    const real m = K(1.0) - VoH;
    return lane_select(m > K(0.0), m, lanes(K(0.0)));
}

// Schlick 1994, eq. 24: F = F0 + (F90 − F0) (1 − VoH)^5. Returns (1 − VoH)^5, the weight of F90.
KILN_FUNCTION real fresnel_schlick_weight(real VoH) {
    const real m = fresnel_one_minus(VoH);
    const real m2 = m * m;
    return m2 * m2 * m;
}

KILN_FUNCTION real fresnel_none(KILN_GLOBAL const scalar* p, real VoH) {
    (void)p;
    (void)VoH;
    return lanes(K(1.0));
}

// p: F0, F90 − F0.
KILN_FUNCTION real fresnel_schlick(KILN_GLOBAL const scalar* p, real VoH) {
    return lane_fma(lanes(p[1]), fresnel_schlick_weight(VoH), lanes(p[0]));
}

// p: F0, F90 − F0, exponent > 0.
KILN_FUNCTION real fresnel_schlick_power(KILN_GLOBAL const scalar* p, real VoH) {
    const real weight = lane_pow_one_minus(lane_saturate(VoH), lanes(p[2]));
    return lane_fma(lanes(p[1]), weight, lanes(p[0]));
}

// Exact, unpolarised; η = n_t / n_i. p: e = η² − 1, η², F where all is reflected (0 for η = 1).
// With u = VoH, s² = 1 − u² and g = √(η² − s²): r_s = −e / (u + g)² and r_p = −r_s (u g − s²) /
// (u g + s²), in which nothing cancels as η → 1. F is their mean square over one division.
KILN_FUNCTION real fresnel_dielectric(KILN_GLOBAL const scalar* p, real VoH) {
    const real u = lane_select(VoH < K(1.0), VoH, lanes(K(1.0)));
    const real s2 = (K(1.0) - u) * (K(1.0) + u);
    real g2;
    if (p[1] < K(0.5))
        g2 = p[1] - s2;
    else
        g2 = lane_fma(u, u, lanes(p[0]));
    const real g = lane_sqrt(lane_select(g2 > K(0.0), g2, lanes(K(1.0))));
    const real sum = u + g;
    const real x = u * g;
    const real t = p[0] / (sum * sum * (x + s2));
    return lane_select(g2 > K(0.0), t * t * lane_fma(x, x, s2 * s2), lanes(p[2]));
}

// Exact, unpolarised; ε = (η + i k)². p: Re ε − 1, Re ε, Im ε, |ε − 1|. With a + i b = √(ε − s²)
// and w = a² + b²: |r_s| = |ε − 1| / ((u + a)² + b²), and |r_p / r_s|² = ((u a − s²)² + (u b)²) /
// ((u a + s²)² + (u b)²). F is their mean square over one division.
KILN_FUNCTION real fresnel_conductor(KILN_GLOBAL const scalar* p, real VoH) {
    const real u = lane_select(VoH < K(1.0), VoH, lanes(K(1.0)));
    const real s2 = (K(1.0) - u) * (K(1.0) + u);
    real t;
    if (p[1] < K(0.5))
        t = p[1] - s2;
    else
        t = lane_fma(u, u, lanes(p[0]));
    const real size = lane_select(t < K(0.0), -t, t);
    const real w = lane_sqrt(lane_fma(t, t, lanes(p[2] * p[2])));
    const real large = lane_sqrt(K(0.5) * (w + size));  // of a and b
    const real divisor = lane_select(large > K(0.0), large, lanes(K(1.0)));
    const real small = K(0.5) * p[2] / divisor;
    const real a = lane_select(t < K(0.0), small, large);
    const real b = lane_select(t < K(0.0), large, small);
    const real ua = u + a;
    const real s = lane_fma(ua, ua, b * b);
    const real up = lane_fma(u, a, s2);
    const real ub = u * b;
    const real below = s * s * lane_fma(up, up, ub * ub);
    const real above = p[3] * p[3] * lane_fma(u * u, w, s2 * s2);
    return above / lane_select(below > K(0.0), below, lanes(K(1.0)));
}

// Hoffman 2019 as MaterialX has it, F82 a tint: F = F0 + (1 − F0) m^5 − b VoH m^6, m = 1 − VoH.
// p: F0, 1 − F0, −b.
KILN_FUNCTION real fresnel_f82_tint(KILN_GLOBAL const scalar* p, real VoH) {
    const real m = fresnel_one_minus(VoH);
    const real bend = lane_fma(p[2] * VoH, m, lanes(p[1]));
    return lane_fma(fresnel_schlick_weight(VoH), bend, lanes(p[0]));
}

KILN_CALLED real fresnel(const int model, KILN_GLOBAL const scalar* p, real VoH) {
    if (model == KILN_FRESNEL_SCHLICK) return fresnel_schlick(p, VoH);
    if (model == KILN_FRESNEL_SCHLICK_POWER) return fresnel_schlick_power(p, VoH);
    if (model == KILN_FRESNEL_DIELECTRIC) return fresnel_dielectric(p, VoH);
    if (model == KILN_FRESNEL_CONDUCTOR) return fresnel_conductor(p, VoH);
    if (model == KILN_FRESNEL_F82_TINT) return fresnel_f82_tint(p, VoH);
    return fresnel_none(p, VoH);
}
