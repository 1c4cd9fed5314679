// SPDX-License-Identifier: Apache-2.0
// Fresnel terms.

// Schlick 1994, eq. 24: F = F0 + (F90 − F0) (1 − VoH)^5. Returns (1 − VoH)^5, the weight of F90.
// VoH may exceed 1 by rounding; the base is then 0, not negative.
KILN_FUNCTION real fresnel_schlick_weight(real VoH) {
    const real base = K(1.0) - VoH;
    const real m = lane_select(base > K(0.0), base, lanes(K(0.0)));
    const real m2 = m * m;
    return m2 * m2 * m;
}
