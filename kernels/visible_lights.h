// SPDX-License-Identifier: Apache-2.0
// Visible normals that mirror the view above the horizon, and no others: what ggx_sample_vndf()
// finds out one sample at a time stands here in the limits of the integral. The horizon is an edge
// across the unit square there, which N strata know to N^-3/4 (He, Wang 2015), and at low roughness
// so rare a one that they miss it; here it is a side of the square.
//
// Visible normals in the stretched space are half way from the stretched view v to a direction that
// is even over the sphere (Dupuy, Benyoub 2023): with e perpendicular to v, at the azimuth φ about
// it, m = v cos δ + e sin δ has an even sin²δ. NoL > 0 where vz (α² mxy² − mz²) < 2 vx mx mz: a
// quadratic in tan δ, of which one root is positive, so sin²δ ends at `share` of the sphere.
// Towards the horizon, where G2 / G1 falls to 0 within NoL ~ α, points are dense: sin²δ is share
// u, u = 1 − (1 − t)².

// The point is (cos φ, √u, 2 (1 − t), u, 1 − u).
typedef struct {
    HalfVector h;
    real NoH;     // of the unnormalised h
    real weight;  // f NoL / pdf without G2 / G1
} VisibleLight;

// sin²δ at the horizon and cos²δ, without a subtraction. The quadratic is a τ² + 2 b τ − c = 0.
typedef struct {
    real sin2, cos2;
} Horizon;

KILN_FUNCTION Horizon visible_horizon(View view, scalar cos_phi) {
    const real alpha2 = view.alpha * view.alpha, vx2 = view.vx * view.vx;
    const real spread = view.one_minus_alpha2 * vx2;  // (1 − α²) vx²
    const real a = view.vz * lane_fma(spread, lanes(cos_phi * cos_phi), alpha2);
    const real b = view.vx * (alpha2 + spread) * cos_phi;
    const real c = view.vz * (K(1.0) + spread);
    const real root = lane_root(lane_fma(a, c, b * b));
    // The light leans over the view's own horizon (b > 0) or away from it.
    const real sum = root + lane_abs(b);
    const real along = lane_select(b > K(0.0), c, sum), across = lane_select(b > K(0.0), sum, a);
    const real along2 = along * along, across2 = across * across, all = along2 + across2;
    const real none = lanes(K(0.0)), one = lanes(K(1.0));
    const real inverse = one / lane_select(all > none, all, one);
    Horizon horizon;  // what is no number any more is so where α is: nothing is below the horizon
    horizon.sin2 = lane_select(all > none, along2 * inverse, one);
    horizon.cos2 = across2 * inverse;
    return horizon;
}

KILN_FUNCTION VisibleLight light_above(View view, Horizon horizon,
                                       KILN_GLOBAL const scalar* point) {
    const real sine = lane_root(horizon.sin2) * point[1];
    const real cosine = lane_root(lane_fma(horizon.sin2, lanes(point[4]), horizon.cos2));
    VisibleLight sample;
    sample.NoH = lane_fma(view.vz, cosine, -(view.vx * point[0]) * sine);
    sample.h.VoH2 = K(2.0) * cosine;
    sample.h.hh = lane_fma(view.one_minus_alpha2, sample.NoH * sample.NoH, view.alpha * view.alpha);
    sample.weight = horizon.sin2 * (K(2.0) * view.inverse_cap) * point[2];
    return sample;
}

KILN_FUNCTION VisibleLight sample_visible_light(View view, KILN_GLOBAL const scalar* point) {
    return light_above(view, visible_horizon(view, point[0]), point);
}
