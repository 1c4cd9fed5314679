// SPDX-License-Identifier: Apache-2.0
// The microfacet lobes beside the fast path of ggx.h: every distribution under every masking, in
// plain vectors. A lobe is D(h) V(NoV, NoL) F(VoH), with the visibility V = G2 / (4 NoV NoL) in
// forms that need no division by a cosine.

// A sampled light, in what lobes read of it. `factor` is NoL / pdf, with as much of D as the
// sampler's density cancels left out.
typedef struct {
    real NoV, sinV, NoL, sinL, VoH, NoH, sin2_H;
    real factor;
} Scattering;

// Squared last: α⁴ is no number in float below α = 1e-9.
KILN_FUNCTION real ggx_D(real alpha, real NoH, real sin2_H) {
    const real ratio = alpha / lane_fma(alpha * alpha, NoH * NoH, sin2_H);
    return ratio * ratio / KILN_PI;
}

// Beckmann, Spizzichino 1963, as in Walter et al. 2007, eq. 25.
// What is 0 stays 0 where the square of α cos² is none.
KILN_FUNCTION real beckmann_D(real alpha, real NoH, real sin2_H) {
    const real slope = alpha * NoH, tiny = lanes(KILN_TINY);
    const real inverse = K(1.0) / lane_max(slope * NoH, tiny);
    const real x = sin2_H / lane_max(slope * slope, tiny);
    const real e = lane_exp(-lane_min(x, lanes(K(1000.0))));
    return lane_select(e > K(0.0), e * inverse * (inverse / KILN_PI), lanes(K(0.0)));
}

#define KILN_DISTRIBUTION_ROW(number, word) \
    if (distribution == KILN_DISTRIBUTION_##number) D = word##_D(alpha, NoH, sin2_H);

// At α = 0 it is no function: infinite, so that sampling it fails instead of missing it in silence.
// Charlie's normals then lie along the horizon and send light up for a view along it alone.
KILN_CALLED real microfacet_D(const int distribution, real alpha, real NoV, real NoH, real sin2_H) {
    real D = lanes(K(0.0));
    KILN_DISTRIBUTION_ROWS(KILN_DISTRIBUTION_ROW)
    if (distribution == KILN_DISTRIBUTION_CHARLIE)
        alpha = lane_select(NoV > K(0.0), lanes(K(1.0)), alpha);
    return lane_select(alpha > K(0.0), D, K(1.0) / alpha);
}

// Of Beckmann, NoX Λ over α sinX / (2√π): Heitz 2014, eq. 68, with a = NoX / (α sinX) and Λ as
// lane_erfcx_deficit() has it.
KILN_FUNCTION real beckmann_tail(real slope, real NoX) {
    const real a = lane_min(NoX / lane_max(slope, lanes(K(1e-30))), lanes(K(30.0)));
    return lane_exp_minus_square(a) * lane_erfcx_deficit(a);
}
#define KILN_BECKMANN_TAIL K(0.28209479177387814)  // 1 / (2√π)

// NoX (1 + Λ(NoX)), regular at NoX = 0. GGX: Heitz 2014, eq. 72.
KILN_FUNCTION real smith_reach(const int distribution, real alpha, real NoX, real sinX) {
    const real slope = alpha * sinX;
    if (distribution == KILN_DISTRIBUTION_GGX)
        return K(0.5) * (NoX + lane_sqrt(lane_fma(NoX, NoX, slope * slope)));
    return lane_fma(slope * KILN_BECKMANN_TAIL, beckmann_tail(slope, NoX), NoX);
}

// NoX Λ(NoX), without the subtraction.
KILN_FUNCTION real smith_excess(const int distribution, real alpha, real NoX, real sinX) {
    const real slope = alpha * sinX;
    if (distribution == KILN_DISTRIBUTION_GGX) {
        const real S = lane_sqrt(lane_fma(NoX, NoX, slope * slope));
        return K(0.5) * slope * (slope / (NoX + S));
    }
    return slope * KILN_BECKMANN_TAIL * beckmann_tail(slope, NoX);
}

// Karis 2013: Schlick's G1 = NoX / (NoX (1 − k) + k).
KILN_FUNCTION real karis_visibility(real k, real NoV, real NoL) {
    const real rest = K(1.0) - k;
    return K(0.25) / (lane_fma(NoV, rest, k) * lane_fma(NoL, rest, k));
}

// The visibility of a word of the contract is WORD_visibility(), from the directions' cosines and
// sines.
KILN_FUNCTION real smith_correlated_visibility(const int distribution, real alpha, Scattering s) {
    const real view = smith_reach(distribution, alpha, s.NoV, s.sinV);
    const real light = smith_reach(distribution, alpha, s.NoL, s.sinL);
    return K(0.25) / (lane_fma(s.NoL, view, s.NoV * light) - s.NoV * s.NoL);
}

KILN_FUNCTION real smith_separable_visibility(const int distribution, real alpha, Scattering s) {
    const real view = smith_reach(distribution, alpha, s.NoV, s.sinV);
    return K(0.25) / (view * smith_reach(distribution, alpha, s.NoL, s.sinL));
}

KILN_FUNCTION real karis_ibl_visibility(const int distribution, real alpha, Scattering s) {
    (void)distribution;
    return karis_visibility(K(0.5) * alpha, s.NoV, s.NoL);
}

KILN_FUNCTION real karis_direct_visibility(const int distribution, real alpha, Scattering s) {
    (void)distribution;
    const real r = lane_sqrt(alpha) + K(1.0);
    return karis_visibility(K(0.125) * r * r, s.NoV, s.NoL);
}

// Unreal 4's approximation of correlated Smith.
KILN_FUNCTION real unreal_joint_visibility(const int distribution, real alpha, Scattering s) {
    (void)distribution;
    const real rest = K(1.0) - alpha, view = lane_fma(s.NoV, rest, alpha);
    return K(0.5) / lane_fma(s.NoL, view, s.NoV * lane_fma(s.NoL, rest, alpha));
}

// Neubelt, Pettineo 2013.
KILN_FUNCTION real neubelt_visibility(const int distribution, real alpha, Scattering s) {
    (void)distribution;
    (void)alpha;
    return K(0.25) / lane_fma(-s.NoL, s.NoV, s.NoL + s.NoV);
}

KILN_FUNCTION real charlie_visibility(const int distribution, real alpha, Scattering s) {
    (void)distribution;
    return charlie_fit_visibility(0, alpha, s.NoV, s.NoL);
}

#define KILN_MASKING_ROW(number, word) \
    if (masking == KILN_MASKING_##number) return word##_visibility(distribution, alpha, s);

KILN_CALLED real microfacet_visibility(const int distribution, const int masking, real alpha,
                                       Scattering s) {
    KILN_MASKING_ROWS(KILN_MASKING_ROW)
    return charlie_fit_visibility(1, alpha, s.NoV, s.NoL);
}

// D V, from a multiple of D. A D that vanishes does so faster than a masking grows towards
// NoV = NoL = 0. Charlie's masking is infinite at NoV = 0, and no D makes less of it.
KILN_FUNCTION real microfacet_product(const int distribution, const int masking, real alpha,
                                      Scattering s, real D) {
    const real V = microfacet_visibility(distribution, masking, alpha, s);
    const real none = lanes(K(0.0));
    real vanished = none;
    if (is_charlie_masking(masking)) vanished = lane_select(s.NoV > none, none, V);
    return lane_select(D == none, vanished, D * V);
}

// D of Beckmann over that of GGX at a normal of ggx_sample_vndf(), not yet normalised: with
// x = tan²θ / α² it is exp(−x) (1 + x)², at most 4 / e. So GGX's visible normals serve Beckmann's
// lobe: where they are too many, they are so by a bounded factor. From x = 80 on, where it is
// 1e-31, it stays. `spread` is 1 + x: of the normal before it is stretched back, its square over
// that of its z.
KILN_CALLED real beckmann_over_ggx(real spread) {
    spread = lane_max(lane_min(spread, lanes(K(81.0))), lanes(K(1.0)));
    return lane_exp(K(1.0) - spread) * (spread * spread);
}

// V and L from a point of the hemisphere: cosine (density NoL / π) and uniform (1 / 2π) sampling.
// The point is (cos φ, NoL, sin θL).
KILN_FUNCTION Scattering scatter_hemisphere(const int importance, real NoV, scalar cos_phi,
                                            scalar NoL, scalar sinL) {
    Scattering s;
    s.NoV = NoV;
    s.sinV = lane_sqrt((K(1.0) - NoV) * (K(1.0) + NoV));
    s.NoL = lanes(NoL);
    s.sinL = lanes(sinL);
    // h = V + L: |h|² = 4 VoH², and its part in the plane as a sum of which no term is negative: a
    // narrow D reads it where V and L are nearly opposite in azimuth, and it is the same with V and
    // L exchanged. sinV − sinL from the cosines: along the horizon both sines are 1.
    const real sines = s.sinV + s.sinL;
    const real divisor = lane_select(sines > K(0.0), sines, lanes(K(1.0)));
    const real apart = (NoL - NoV) * (NoL + NoV) / divisor;
    const real around = K(2.0) * (s.sinV * s.sinL) * (K(1.0) + cos_phi);
    const real hxy2 = lane_fma(apart, apart, around);
    const real hz = NoV + NoL;
    const real floor = lanes(K(0.0));
    const real hh = lane_fma(hz, hz, hxy2);
    const real divisor_hh = lane_select(hh > floor, hh, lanes(K(1.0)));
    const real inverse = lane_select(hh > floor, K(1.0) / divisor_hh, floor);
    s.VoH = K(0.5) * lane_sqrt(hh);
    s.sin2_H = hxy2 * inverse;
    s.NoH = hz * lane_sqrt(inverse);
    s.factor =
        importance == KILN_IMPORTANCE_COSINE ? lanes(KILN_PI) : lanes(K(2.0) * KILN_PI * NoL);
    return s;
}

// Beckmann's normals: tan²θ = −α² ln u = α² T². The point is (T cos φ, 1, T²).
KILN_FUNCTION HalfVector beckmann_sample_ndf(View view, KILN_GLOBAL const scalar* point) {
    HalfVector h;
    h.VoH2 = lane_fma(K(2.0) * view.vx, lanes(point[0]), K(2.0) * view.vz);
    h.hh = lane_fma(view.alpha * view.alpha, lanes(point[2]), lanes(K(1.0)));
    return h;
}

// From a half vector (unnormalised, ggx.h) drawn from D NoH, or from GGX's visible normals. D
// cancels: NoL / (D NoH / 4 VoH) and NoL / (G1 D / 4 NoV), G1 / NoV = 2 / (NoV + S).
KILN_FUNCTION Scattering scatter_half_vector(const int importance, View view, HalfVector h,
                                             real NoH) {
    const real hh = lane_select(h.hh > K(0.0), h.hh, lanes(K(1.0)));
    const real inverse = K(1.0) / hh, root = lane_sqrt(inverse);
    Scattering s;
    // α = 0 at NoV = 0: the mirror's limit, from a view that is as good as grazing. Nearer to it
    // the products of two cosines are no numbers.
    view.S = lane_max(view.S, lanes(KILN_ROOT_TINY));
    s.NoV = view.vz * view.S;
    s.sinV = lane_sqrt((K(1.0) - s.NoV) * (K(1.0) + s.NoV));
    s.VoH = K(0.5) * view.S * h.VoH2 * root;
    s.NoH = NoH * root;
    s.sin2_H = lanes(K(0.0));
    const real NoL = view.S * lane_fma(h.VoH2, NoH, -(view.vz * h.hh)) * inverse;
    s.NoL = lane_select(NoL < K(1.0), NoL, lanes(K(1.0)));
    s.sinL = lane_sqrt((K(1.0) - s.NoL) * (K(1.0) + s.NoL));
    s.factor = importance == KILN_IMPORTANCE_VNDF ? K(2.0) * s.NoL * (s.NoV + view.S)
                                                  : K(4.0) * s.NoL * s.VoH / s.NoH;
    return s;
}
