// SPDX-License-Identifier: Apache-2.0
// Sampling the GGX distribution (Walter et al. 2007, eq. 33). D itself never appears: it cancels in
// both estimators, which keeps α → 0 finite.
//
// The view lies in the plane y = 0. By symmetry an azimuth enters through its cosine alone, and the
// host hands cosines over in the points: no trigonometry here. Half vectors stay unnormalised, with
// an N·h that is the same in every lane: the sampler's own, or the point's second scalar. S is
// the length of the stretched view (α sinθ, 0, NoV), which is also its Smith length (smith.h).

typedef struct {
    real NoV, S;
    real vx, vz;  // stretched view, unit; vz = NoV / S
    real one_minus_vz;
    real inverse_cap;  // 1 / (1 + vz)
    real alpha;
    real one_minus_alpha2;  // 1 − α²
    real alpha_over_S;
} View;

typedef struct {
    real VoH2;  // 2 V·h / S
    real hh;    // h·h
} HalfVector;

// The light that mirrors the view, L = 2 (V·h) h / h·h − V, with NoL and S(NoL) scaled by
// KILN_LIGHT_SCALE h·h / S: the power of two keeps their squares among the normal numbers of float
// where h·h is small.
#define KILN_LIGHT_SCALE K(16777216.0)
typedef struct {
    real NoL;
    real S;
} Light;

// α = 0 at NoV = 0 has no stretched direction: vz = 1 gives the limit of the mirror, E = 1 and B
// = 1.
KILN_FUNCTION View ggx_view(real NoV, real alpha) {
    const real slope = alpha * lane_sqrt((K(1.0) - NoV) * (K(1.0) + NoV));
    const real S = lane_sqrt(NoV * NoV + slope * slope);
    const real divisor = lane_select(S > K(0.0), S, lanes(K(1.0)));
    View view;
    view.NoV = NoV;
    view.S = S;
    view.vx = slope / divisor;
    view.vz = lane_select(S > K(0.0), NoV / divisor, lanes(K(1.0)));
    view.inverse_cap = K(1.0) / (K(1.0) + view.vz);
    view.one_minus_vz = view.vx * (view.vx * view.inverse_cap);
    view.alpha = alpha;
    view.one_minus_alpha2 = (K(1.0) - alpha) * (K(1.0) + alpha);
    view.alpha_over_S = alpha / divisor;
    return view;
}

// Visible normals by spherical caps (Dupuy, Benyoub 2023, listing 3): a direction c with
// c.z = (1 − u)(1 + vz) − vz, and h = (c + v) / (1 + vz) before it is stretched back. |c| = |v| = 1
// gives |h.xy|² = 2 v·h / (1 + vz) − h.z². Over 1 + vz the sine of c is √(u (1 − u + tan²)), with
// the tangent of half the view's angle, and h.z is 1 − u: all is divided by that, which leaves h.z
// out of every product, and given the one length that leaves it out of the light's as well. A point
// is 2^-33 from the rim at the least: h·h stays below 2^20. With r = 1 / (1 − u), the point is
// (2 √(u r) cos φ in that length, r).
#define KILN_VISIBLE_NOH (K(1.0) / KILN_LIGHT_SCALE)

// The sine of such a c over √(u r), times vx.
KILN_FUNCTION real ggx_cap_reach(View view, KILN_GLOBAL const scalar* point) {
    return lane_sqrt(
        lane_fma(view.one_minus_vz * view.one_minus_vz, lanes(point[1]), view.vx * view.vx));
}

KILN_FUNCTION HalfVector ggx_visible_normal(View view, KILN_GLOBAL const scalar* point,
                                            real reach) {
    const real r = lanes(point[1]), alpha2_over_cap = view.alpha * view.alpha * view.inverse_cap;
    HalfVector h;
    h.VoH2 = lane_fma(lanes(point[0]), reach,
                      lane_fma((K(2.0) * KILN_VISIBLE_NOH) * view.one_minus_vz, r,
                               (K(2.0) * KILN_VISIBLE_NOH) * view.vz));
    h.hh = lane_fma(KILN_VISIBLE_NOH * alpha2_over_cap, h.VoH2 * r,
                    (KILN_VISIBLE_NOH * KILN_VISIBLE_NOH) * view.one_minus_alpha2);
    return h;
}

KILN_FUNCTION HalfVector ggx_sample_vndf(View view, KILN_GLOBAL const scalar* point) {
    return ggx_visible_normal(view, point, ggx_cap_reach(view, point));
}

// h·h over h.z² of such a normal before it is stretched back.
KILN_FUNCTION real visible_normal_spread(View view, HalfVector h, KILN_GLOBAL const scalar* point) {
    return h.VoH2 * view.inverse_cap * (point[1] * (K(1.0) / KILN_VISIBLE_NOH));
}

// All normals (Walter et al. 2007, eq. 35): tan²θ = α² u / (1 − u), h = (α √u cos φ, α √u sin φ,
// √(1 − u)). The point is (√u cos φ, √(1 − u), 1 / √(1 − u), 1 − u).
KILN_FUNCTION HalfVector ggx_sample_ndf(View view, KILN_GLOBAL const scalar* point) {
    HalfVector h;
    h.VoH2 = lane_fma(K(2.0) * view.vx, lanes(point[0]), (K(2.0) * view.vz) * point[1]);
    h.hh = lane_fma(view.one_minus_alpha2, lanes(point[3]), view.alpha * view.alpha);
    return h;
}

// The density of visible normals over that of all normals, G1(V) (V·h)⁺ / (NoV NoH). Its mean over
// all normals is 1. inverse_NoH comes with the point of ggx_sample_ndf; log-uniform tangents and
// horizon normals bring it times the density of all normals over their own.
KILN_FUNCTION real ggx_vndf_over_ndf(View view, HalfVector h, real inverse_NoH) {
    return lane_select(h.VoH2 > K(0.0), h.VoH2 * inverse_NoH * view.inverse_cap, lanes(K(0.0)));
}

// NoL of it and S², whose root may wait.
typedef struct {
    real NoL;
    real S2;
} Mirrored;

KILN_FUNCTION Mirrored ggx_mirrored(View view, HalfVector h, real NoH) {
    const real edge = (KILN_LIGHT_SCALE * view.alpha_over_S) * h.hh;
    Mirrored light;
    light.NoL = lane_fma(-(KILN_LIGHT_SCALE * view.vz), h.hh, (KILN_LIGHT_SCALE * NoH) * h.VoH2);
    light.S2 = lane_fma(view.one_minus_alpha2, light.NoL * light.NoL, edge * edge);
    return light;
}

KILN_FUNCTION Light ggx_mirror(View view, HalfVector h, real NoH) {
    const Mirrored mirrored = ggx_mirrored(view, h, NoH);
    const Light light = {mirrored.NoL, lane_root(mirrored.S2)};
    return light;
}

// S² − NoL² = α² (1 − NoL²) of the light, in its scale.
KILN_FUNCTION real ggx_excess(View view, HalfVector h, Light light) {
    const real edge = (KILN_LIGHT_SCALE * view.alpha_over_S) * h.hh;
    const real middle = view.alpha * light.NoL;
    return (edge - middle) * (edge + middle);
}

KILN_FUNCTION real ggx_VoH(View view, HalfVector h) {
    return (K(0.5) * view.S) * h.VoH2 * lane_rsqrt(h.hh);
}

KILN_FUNCTION real ggx_one_minus_VoH(View view, HalfVector h) {
    return lane_fma_rsqrt((K(-0.5) * view.S) * h.VoH2, h.hh, lanes(K(1.0)));
}
