// SPDX-License-Identifier: Apache-2.0
// Estevez and Kulla 2017: the distribution Charlie, and a fit to Smith's integral over it.

// Eq. 2: (2 + 1/α) sin^(1/α) / 2π. Near the horizon from the cosine, since a
// sine next to 1 has lost what the power reads.
KILN_FUNCTION real charlie_D(real alpha, real NoH, real sin2_H) {
    const real inverse = K(1.0) / lane_max(alpha, lanes(K(1e-30))), half_power = K(0.5) * inverse;
    const real c2 = lane_min(NoH * NoH, lanes(K(1.0)));
    const real power = lane_select(sin2_H > K(0.5), lane_pow_one_minus(c2, half_power),
                                   lane_pow(sin2_H, half_power));
    return (K(2.0) + inverse) * power / (K(2.0) * KILN_PI);
}

// No word of its own: charlie with terminator_softening.
#define KILN_MASKING_CHARLIE_SOFTENED KILN_MASKING_COUNT

KILN_FUNCTION int is_charlie_masking(const int masking) {
    return masking == KILN_MASKING_CHARLIE || masking == KILN_MASKING_CHARLIE_SOFTENED;
}

// Eq. 3 and table 1: Λ = exp L(NoX) below 1/2, exp(2 L(1/2) − L(1 − NoX))
// above, L(x) = a / (1 + b x^c) + d x + e.
KILN_FUNCTION real charlie_L(real alpha, real x) {
    const real t = (K(1.0) - alpha) * (K(1.0) - alpha);
    const real a = lane_fma(t, lanes(K(25.3245) - K(21.5473)), lanes(K(21.5473)));
    const real b = lane_fma(t, lanes(K(3.32435) - K(3.82987)), lanes(K(3.82987)));
    const real c = lane_fma(t, lanes(K(0.16801) - K(0.19823)), lanes(K(0.19823)));
    const real d = lane_fma(t, lanes(K(-1.27393) + K(1.97760)), lanes(K(-1.97760)));
    const real e = lane_fma(t, lanes(K(-4.85967) + K(4.32054)), lanes(K(-4.32054)));
    return a / (K(1.0) + b * lane_pow(x, c)) + d * x + e;
}

KILN_CALLED real charlie_log_lambda(real alpha, real NoX) {
    const real low = charlie_L(alpha, NoX);
    const real high = K(2.0) * charlie_L(alpha, lanes(K(0.5))) - charlie_L(alpha, K(1.0) - NoX);
    return lane_select(NoX < K(0.5), low, high);
}

// 1 / ((1 + Λv + Λl) 4 NoV NoL). Infinite at NoV = 0, as the model is. Softened: the light's Λ
// to the power 1 + 2 (1 − NoL)^8 (eq. 4).
KILN_FUNCTION real charlie_fit_visibility(const int softened, real alpha, real NoV, real NoL) {
    real log_light = charlie_log_lambda(alpha, NoL);
    if (softened) {
        const real m = K(1.0) - NoL, m2 = m * m, m4 = m2 * m2;
        log_light = log_light * lane_fma(lanes(K(2.0)), m4 * m4, lanes(K(1.0)));
    }
    const real sum = K(1.0) + lane_exp(charlie_log_lambda(alpha, NoV)) + lane_exp(log_light);
    return K(0.25) / (sum * NoV * NoL);
}
