// SPDX-License-Identifier: Apache-2.0
// Normals for 1 − E_avg at low roughness. Where α ≪ NoV half of what is lost is lost to masking, by
// normals of the peak, tan θ ~ α, and half below the horizon, by the peak's far tail: from the
// tangent that mirrors the view into the horizon, NoV / (1 + √(1 − NoV²)), to a few times that. So
// one point in four takes all normals (ggx_sample_ndf()), and three a density as wide as that
// tangent β, β tan θ / (β² + tan²θ)^1.5 of tan θ, whose tail falls as slowly as the integrand does;
// each is divided by the density of both (Veach, Guibas 1995: the balance heuristic). A sample's
// variance is then 6 to 8 times the squared mean from α = 1e-4 to .1; by log-uniform tangents 100.
// For averages alone: where NoV ≪ α light is lost by tangents up to 1 / NoV, which these hardly
// know, and which an average weighs by NoV³.

// Half vectors (k s cos φ, k s sin φ, c) with s² + c² = 1, of width k = α or β. The point is (s cos
// φ, c, weight of NoV / c, s², 1 where k = α and 0 where k = β, NoV).
typedef struct {
    HalfVector h;
    real inverse_NoH;  // times the density of all normals over the point's own
} HorizonNormal;

KILN_FUNCTION HorizonNormal sample_horizon_normal(View view, KILN_GLOBAL const scalar* point) {
    const real alpha = view.alpha, alpha2 = alpha * alpha;
    const real sine = lane_root((K(1.0) - view.NoV) * (K(1.0) + view.NoV));
    const real tangent = view.NoV / (K(1.0) + sine);
    // Never narrower than the lobe: nothing divides by NoV.
    const real beta = lane_root(lane_fma(tangent, tangent, alpha2)), beta2 = beta * beta;
    const real width = lane_select(lanes(point[4]) > K(0.5), alpha, beta);
    const scalar c = point[1], c2 = c * c;
    const real c2_tan2 = width * width * point[3];
    const real own = lane_fma(alpha2, lanes(c2), c2_tan2) / alpha;
    const real wide = lane_fma(beta2, lanes(c2), c2_tan2);
    // The wide density over that of all normals is `above` / `below`.
    const real above = beta * (own * own), below = (K(2.0) * c) * wide * lane_root(wide);
    HorizonNormal sample;
    sample.h.VoH2 =
        lane_fma((K(2.0) * view.vx) * (width / alpha), lanes(point[0]), (K(2.0) * view.vz) * c);
    sample.h.hh = lanes(c2) + c2_tan2;
    sample.inverse_NoH = (K(4.0) * point[2]) * below / lane_fma(lanes(K(3.0)), above, below);
    return sample;
}
