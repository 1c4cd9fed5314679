// SPDX-License-Identifier: Apache-2.0
// Deterministic quadrature of a diffuse lobe: its albedo, or that under what a Fresnel term lets
// through, 1 − F(VoH). The lobes of diffuse.h are analytic but for two folds, at NoL = NoV and
// where the azimuth is a right angle, so Gauss–Legendre rules meet there: two pieces of the
// elevation, two of the half circle. The elevation's variable is t = tan(θ / 2), in which sine and
// cosine are rational and nothing is singular at the pole. Towards the fold t is cubic in the node,
// since the divisors of the Oren–Nayar family have a pole just beyond it where NoV is small;
// towards the horizon it is quadratic.

// Both signs of cos φ at every node of the right angle; their weights add up to 1/2.
KILN_FUNCTION real quadrature_ring(const int diffuse, const int model, KILN_GLOBAL const scalar* p,
                                   real NoV, real roughness, real NoL, real sinL,
                                   KILN_GLOBAL const scalar* nodes, const unsigned int count) {
    real sum = lanes(K(0.0));
    for (unsigned int i = 0; i < 2 * count; ++i) {
        const scalar cosine = nodes[i & ~1u], weight = nodes[i | 1u];
        const Directions d = diffuse_directions(NoV, NoL, sinL, i & 1u ? -cosine : cosine);
        real lobe = diffuse_lobe(diffuse, d, roughness, p[KILN_FRESNEL_PARAMETERS]);
        if (model != KILN_FRESNEL_NONE) lobe = lobe * (K(1.0) - fresnel(model, p, d.VoH));
        sum += weight * lobe;
    }
    return sum;
}

// `nodes`: (node, weight) of the Gauss–Legendre rule of `order` nodes on [0, 1], then (cos φ,
// weight) of `azimuths` angles in [0, π/2], of weight 1/2 together. p: the scalars of the Fresnel
// term (fresnel.h), then the diffuse albedo.
KILN_FUNCTION real quadrature_diffuse(const int diffuse, const int model,
                                      KILN_GLOBAL const scalar* p, real NoV, real alpha,
                                      KILN_GLOBAL const scalar* nodes, const unsigned int order,
                                      const unsigned int azimuths) {
    const real one = lanes(K(1.0)), roughness = lane_sqrt(alpha);
    const real fold = lane_sqrt((K(1.0) - NoV) * (K(1.0) + NoV)) / (K(1.0) + NoV);
    real sum = lanes(K(0.0));
    for (unsigned int i = 0; i < 2 * order; ++i) {
        const scalar u = nodes[i & ~1u], weight = nodes[i | 1u];
        const int above = (int)(i & 1u);  // the fold, towards the pole
        const real length = above ? fold : K(1.0) - fold;
        const real t = above ? fold * (K(1.0) - u * u * u) : K(1.0) - length * (u * u);
        const real step = length * (above ? K(3.0) * (u * u) : K(2.0) * u);
        const real scale = one / lane_fma(t, t, one);
        const real sinL = K(2.0) * t * scale;
        const real NoL = (K(1.0) - t) * (K(1.0) + t) * scale;
        const real ring = quadrature_ring(diffuse, model, p, NoV, roughness, NoL, sinL,
                                          nodes + 2 * order, azimuths);
        // dθ = 2 dt / (1 + t²)
        sum += weight * step * (sinL * NoL * scale) * ring;
    }
    return K(4.0) * sum;
}
