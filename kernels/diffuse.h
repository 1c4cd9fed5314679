// SPDX-License-Identifier: Apache-2.0
// Diffuse models, one colour channel at a time: each returns π f, whose mean under cosine sampling
// of the light is the directional albedo. Roughness is the artist's 0…1. Some models rightly return
// an albedo above 1; nothing is clamped that the model's author does not clamp. The function of a
// word of the contract is diffuse_WORD(); its number, KILN_DIFFUSE_WORD, is in words.h.

// View and light above the horizon. cos_phi is that of the azimuth between them, H = (V + L)/|V +
// L|.
typedef struct {
    real NoV, sinV, NoL, sinL, cos_phi, VoH, NoH;
} Directions;

// 1 + V·L is a sum of terms none of which is negative, so that it keeps its digits as V and L
// become opposite along the surface. There VoH = 0, and NoH takes its limit along NoV = NoL, 1.
KILN_FUNCTION Directions diffuse_directions(real NoV, real NoL, real sinL, scalar cos_phi) {
    Directions d;
    d.NoV = NoV;
    d.sinV = lane_sqrt((K(1.0) - NoV) * (K(1.0) + NoV));
    d.NoL = NoL;
    d.sinL = sinL;
    d.cos_phi = lanes(cos_phi);
    const real cosines = d.NoL * d.NoV, sines = d.sinL * d.sinV;
    // 1 − sinL² sinV²
    const real lacking = lane_fma(-cosines, cosines, d.NoL * d.NoL + d.NoV * d.NoV);
    const real one_plus_LoV = cosines + lacking / (K(1.0) + sines) + sines * (K(1.0) + cos_phi);
    d.VoH = lane_sqrt(K(0.5) * one_plus_LoV);
    const real divisor = lane_select(d.VoH > K(0.0), d.VoH, lanes(K(1.0)));
    d.NoH = lane_select(d.VoH > K(0.0), K(0.5) * (d.NoL + d.NoV) / divisor, lanes(K(1.0)));
    return d;
}

// Linear from a at 0 to b at 1.
KILN_FUNCTION real diffuse_mix(real a, real b, real weight) { return lane_fma(weight, b - a, a); }

// V·L less its part along the normal.
KILN_FUNCTION real diffuse_tangential(Directions d) { return d.sinV * d.sinL * d.cos_phi; }

// Cosines as a divisor. Where both are 0 the Oren-Nayar family has a pole: it gets 1, as where
// they are so small that a quotient is infinite.
KILN_FUNCTION real diffuse_divisor(real cosine) {
    return lane_select(cosine >= KILN_TINY, cosine, lanes(K(1.0)));
}
KILN_FUNCTION real diffuse_greater_cosine(Directions d) {
    return diffuse_divisor(lane_max(d.NoV, d.NoL));
}

KILN_FUNCTION real diffuse_lambert(Directions d, real roughness, scalar albedo) {
    (void)d;
    (void)roughness;
    return lanes(albedo);
}

// Burley 2012.
KILN_FUNCTION real diffuse_burley(Directions d, real roughness, scalar albedo) {
    const real rise = K(2.0) * roughness * (d.VoH * d.VoH) - K(0.5);  // FD90 − 1
    const real view = lane_fma(rise, fresnel_schlick_weight(d.NoV), lanes(K(1.0)));
    const real light = lane_fma(rise, fresnel_schlick_weight(d.NoL), lanes(K(1.0)));
    return albedo * (view * light);
}

// Burley's with its energy renormalised, as Frostbite has it (Lagarde, de Rousiers 2014): FD90 is
// r / 2 + 2 r VoH², the whole falls to 1 / 1.51 at r = 1.
KILN_FUNCTION real diffuse_burley_normalized(Directions d, real roughness, scalar albedo) {
    const real rise = roughness * lane_fma(K(2.0) * d.VoH, d.VoH, lanes(K(0.5))) - K(1.0);
    const real view = lane_fma(rise, fresnel_schlick_weight(d.NoV), lanes(K(1.0)));
    const real light = lane_fma(rise, fresnel_schlick_weight(d.NoL), lanes(K(1.0)));
    const real factor = K(1.0) - K(0.33774834437086093) * roughness;
    return albedo * (factor * (view * light));
}

// Oren, Nayar 1994, the qualitative model; roughness is σ in radians. sin α tan β = sinV sinL over
// the greater cosine.
KILN_FUNCTION real diffuse_oren_nayar(Directions d, real roughness, scalar albedo) {
    const real sigma2 = roughness * roughness;
    const real A = K(1.0) - K(0.5) * sigma2 / (sigma2 + K(0.33));
    const real B = K(0.45) * sigma2 / (sigma2 + K(0.09));
    const real s = diffuse_tangential(d);
    const real towards = lane_select(s > K(0.0), s, lanes(K(0.0)));
    return albedo * lane_fma(B, towards / diffuse_greater_cosine(d), A);
}

// Oren, Nayar 1994, the functional approximation with interreflection; roughness is σ in radians.
// Of the polar angles a ≥ b, what is kept are their complements as parts of a right angle:
// x = 1 − 2 a / π. Then sin a − (2 b / π)³ = x_b (3 − 3 x_b + x_b²) − (1 − sin a), which meets its
// factor tan b → ∞ with all its digits.
KILN_FUNCTION real diffuse_oren_nayar_full(Directions d, real roughness, scalar albedo) {
    const real zero = lanes(K(0.0));
    const real sigma2 = roughness * roughness;
    const real flat = sigma2 / (sigma2 + K(0.09));
    const real two_over_pi = lanes(K(0.63661977236758134));
    const real cos_a = lane_min(d.NoV, d.NoL), sin_a = lane_max(d.sinV, d.sinL);
    const real xa = two_over_pi * lane_asin(cos_a);
    const real xb = two_over_pi * lane_asin(lane_max(d.NoV, d.NoL));
    const real cos_b = diffuse_greater_cosine(d);
    const real tan_b = lane_min(d.sinV, d.sinL) / cos_b;
    const real cosines = d.NoV + d.NoL;
    const real tan_mean = (d.sinV + d.sinL) / diffuse_divisor(cosines);
    const real away =
        xb * lane_fma(xb, xb - K(3.0), lanes(K(3.0))) - cos_a * cos_a / (K(1.0) + sin_a);
    const real across = lane_select(d.cos_phi < zero, away, sin_a);
    const real b = K(1.0) - xb, ab = (K(1.0) - xa) * b;
    const real C1 = K(1.0) - K(0.5) * sigma2 / (sigma2 + K(0.33));
    const real C2_tan = K(0.45) * flat * (across * tan_b);
    const real C3_tan = K(0.125) * flat * (ab * ab) * tan_mean;
    const real direct = C1 + d.cos_phi * C2_tan + (K(1.0) - lane_abs(d.cos_phi)) * C3_tan;
    const real mutual = K(0.17) * sigma2 / (sigma2 + K(0.13)) * (K(1.0) - d.cos_phi * (b * b));
    return albedo * lane_fma(lanes(albedo), mutual, direct);
}

// Fujii's Oren-Nayar and its energy-preserving completion (Portsmouth, Kutz, Hill 2025, exact
// form).
#define KILN_FON_C1 K(0.28779340921080622)   // 1/2 − 2 / (3 π)
#define KILN_FON_C2 K(0.072488212456924080)  // 2/3 − 28 / (15 π)

// A_F, the FON albedo of white at normal incidence.
KILN_FUNCTION real diffuse_fon_scale(real roughness) {
    return K(1.0) / lane_fma(lanes(KILN_FON_C1), roughness, lanes(K(1.0)));
}

KILN_FUNCTION real diffuse_fon(Directions d, real roughness, scalar albedo) {
    const real s = diffuse_tangential(d);
    const real s_over_t = lane_select(s > K(0.0), s / diffuse_greater_cosine(d), s);
    return albedo * (diffuse_fon_scale(roughness) * lane_fma(roughness, s_over_t, lanes(K(1.0))));
}

// What FON of white lacks of 1 at one cosine, over A_F r: C1 − G(μ) / π, with
// G = S (acos μ − S μ) + 2/3 S (μ (1 + S + S²) / (1 + S) − 1), S = √(1 − μ²): (1 − S³) / μ without
// the 0/0. This ratio is why r = 0 needs no case of its own.
KILN_FUNCTION real diffuse_fon_lacking(real cosine, real sine) {
    const real cubic = cosine * lane_fma(sine, sine, K(1.0) + sine) / (K(1.0) + sine) - K(1.0);
    const real G = sine * lane_fma(lanes(K(0.66666666666666667)), cubic,
                                   lane_fma(-sine, cosine, lane_acos(cosine)));
    return KILN_FON_C1 - K(0.31830988618379067) * G;
}

KILN_FUNCTION real diffuse_eon(Directions d, real roughness, scalar albedo) {
    const real scale = diffuse_fon_scale(roughness);
    const real lacking = scale * roughness;
    const real mean = scale * lane_fma(lanes(KILN_FON_C2), roughness, lanes(K(1.0)));
    const real mean_lacking = (KILN_FON_C1 - KILN_FON_C2) * lacking;
    const real rho_ms = albedo * albedo * mean / (K(1.0) - albedo * mean_lacking);
    // (1 − E(V)) (1 − E(L)) / (1 − mean)
    const real again = lacking * diffuse_fon_lacking(d.NoV, d.sinV) *
                       diffuse_fon_lacking(d.NoL, d.sinL) / (KILN_FON_C1 - KILN_FON_C2);
    return lane_fma(rho_ms, again, diffuse_fon(d, roughness, albedo));
}

// Unreal Engine 5.7's function of that name, another model: first-order fits, the square of the
// colour in place of ρ_ms, the lacking energy of the view alone (so not reciprocal), and a colour
// adjusted to look like Lambert's.
KILN_FUNCTION real diffuse_eon_unreal(Directions d, real roughness, scalar albedo) {
    const scalar inversion = K(0.189468) - K(0.189468) * albedo;
    const real rho = albedo * lane_fma(lanes(inversion), roughness, lanes(K(1.0)));
    const real s = diffuse_tangential(d);
    const real t = lane_max(lane_max(d.NoV, d.NoL), lanes(K(1e-6)));
    const real s_over_t = lane_max(s / t, s);
    const real scale = K(1.0) - roughness * (KILN_FON_C1 / (K(1.0) + KILN_FON_C1));
    const real single = scale * lane_fma(roughness, s_over_t, lanes(K(1.0)));
    const real G_over_pi = K(0.262048) - K(0.262048) * d.NoV;
    const real multiple = K(1.0) - scale * lane_fma(roughness, G_over_pi, lanes(K(1.0)));
    return rho * lane_fma(rho, multiple, single);
}

// Chan 2018, as Unreal Engine has it, with its upper bound of 1 on f. The floor on r⁴ only keeps
// the division finite: g is 1 from r⁴ = 2 / (2^18 + 1) = 7.6e-6 down.
KILN_FUNCTION real diffuse_chan2018(Directions d, real roughness, scalar albedo) {
    const real alpha = roughness * roughness;
    const real alpha2 = lane_max(alpha * alpha, lanes(K(7e-6)));
    const real g = lane_saturate(lane_log2(K(2.0) / alpha2 - K(1.0)) / K(18.0));
    const real rough = d.VoH + fresnel_schlick_weight(d.VoH);
    const real smooth = (K(1.0) - K(0.75) * fresnel_schlick_weight(d.NoV)) *
                        (K(1.0) - K(0.75) * fresnel_schlick_weight(d.NoL));
    const real front = diffuse_mix(rough, smooth, lane_saturate(K(2.2) * g - K(0.5)));
    const real slope = lane_max(K(73.2) * g - K(21.2), lanes(K(8.9)));
    const real back =
        ((K(34.5) * g - K(59.0)) * g + K(24.5)) * d.VoH * lane_exp2(-slope * lane_sqrt(d.NoH));
    return albedo * lane_min(front + back, lanes(KILN_PI));
}

// Chan 2024, as Unreal Engine 5.7 has it: Lambert at roughness 0.
KILN_FUNCTION real diffuse_chan2024(Directions d, real roughness, scalar albedo) {
    const real alpha = roughness * roughness;
    const real scale = lane_max(K(0.55) - K(0.2) * roughness, K(1.25) - K(1.6) * roughness);
    const real bias = lane_saturate(K(4.0) * alpha);
    const real rough = scale * (d.NoH + bias) / (d.NoH + K(0.025)) * (d.VoH * d.VoH);
    const real single = diffuse_mix(lanes(K(1.0)), rough, roughness);
    return albedo * lane_fma(lanes(K(0.38)), alpha, single);
}

// Light that walks over facets (ggx_lambert.h) has no value at a pair of directions: no number, so
// that nothing can take another lobe for it.
KILN_FUNCTION real diffuse_ggx_lambert(Directions d, real roughness, scalar albedo) {
    (void)d;
    (void)roughness;
    const real none = lanes(albedo - albedo);
    return none / none;
}

#define KILN_DIFFUSE_ROW(number, word) \
    if (model == KILN_DIFFUSE_##number) return diffuse_##word(d, roughness, albedo);

KILN_CALLED real diffuse_lobe(const int model, Directions d, real roughness, scalar albedo) {
    KILN_DIFFUSE_ROWS(KILN_DIFFUSE_ROW)
    return diffuse_lambert(d, roughness, albedo);
}
