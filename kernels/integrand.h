// SPDX-License-Identifier: Apache-2.0
// What one sample of the fast path contributes: GGX under Smith, half vectors from visible or from
// all normals. The terms belong to the closed set from which every quantity is a combination
// (server/compute/terms.h): dead ones are compiled out.

#define KILN_TERM_WEIGHT 1   // f NoL / pdf:             its mean is E
#define KILN_TERM_FRESNEL 2  // (1 − VoH)^5 f NoL / pdf: its mean is B
#define KILN_TERM_DEFICIT 4  // its mean is 1 − E, summed as such since E → 1 at low roughness

// No words of their own: the deficit alone, see weigh(); that of averages, horizon_normals.h;
// visible normals above the horizon, visible_lights.h; these on both sides of a rim,
// parted_lights.h. The last three bring a weight of their own, the last two one of E: batch.h and
// weigh() go by this order.
#define KILN_IMPORTANCE_LOG_TANGENTS KILN_IMPORTANCE_COUNT
#define KILN_IMPORTANCE_HORIZON_NORMALS (KILN_IMPORTANCE_COUNT + 1)
#define KILN_IMPORTANCE_VISIBLE_LIGHTS (KILN_IMPORTANCE_COUNT + 2)
#define KILN_IMPORTANCE_PARTED_LIGHTS (KILN_IMPORTANCE_COUNT + 3)

typedef struct {
    int masking, importance, terms;
} Integrand;

typedef struct {
    real weight, fresnel, deficit;
} Terms;

// N·h of the half vector that a point draws.
KILN_FUNCTION scalar half_vector_NoH(const int importance, KILN_GLOBAL const scalar* point) {
    return importance == KILN_IMPORTANCE_VNDF ? KILN_VISIBLE_NOH : point[1];
}

// Whether weigh(), or what goes before it, reads the half vector and not the light alone.
KILN_FUNCTION int reads_half_vector(const Integrand what) {
    return what.importance == KILN_IMPORTANCE_NDF || (what.terms & ~KILN_TERM_WEIGHT) != 0;
}

// Under visible normals f NoL / pdf = G2 / G1(V); under all normals, that times the ratio of the
// densities. A light below the horizon carries nothing: its sample weighs 0, lacks all, and stays
// in the divisor. Under all normals the deficit is a difference: 1 − G2/G1 times the ratio has no
// finite variance.
// Log-uniform tangents: tanθ = α sinh v with v nearly uniform instead of dense at the peak. The
// directions that lack most lie where visible normals hardly ever go as α → 0; the deficit is 1 −
// G2/G1 times the ratio again, now with the point's own density, which `c` brings along, as it does
// that of horizon normals.
// Visible and parted lights: G2 / G1 times a weight of the sample's own, which `c` is.
KILN_FUNCTION Terms weigh(const Integrand what, View view, HalfVector h, Light light,
                          real one_minus_VoH, real c) {
    real NoL = light.NoL;
    const int apart = what.importance == KILN_IMPORTANCE_LOG_TANGENTS ||
                      what.importance == KILN_IMPORTANCE_HORIZON_NORMALS;
    // Among these many lie so far below the horizon that both divisors are 0; of parted lights
    // those that rounding moves there from a narrow span.
    if (apart || what.importance == KILN_IMPORTANCE_PARTED_LIGHTS)
        NoL = lane_select(NoL > K(0.0), NoL, lanes(K(1.0)));
    const real above = smith_G2_over_G1(what.masking, view.vz, NoL, light.S);
    Terms terms = {lane_select(light.NoL > K(0.0), above, lanes(K(0.0))), lanes(K(0.0)),
                   lanes(K(0.0))};
    if ((what.terms & KILN_TERM_DEFICIT) && what.importance != KILN_IMPORTANCE_NDF) {
        const real excess = ggx_excess(view, h, light);
        const real lacking = smith_deficit(what.masking, view.vz, NoL, light.S, excess);
        terms.deficit = lane_select(light.NoL > K(0.0), lacking, lanes(K(1.0)));
    }
    if (apart) terms.deficit = terms.deficit * ggx_vndf_over_ndf(view, h, c);
    if (what.importance >= KILN_IMPORTANCE_VISIBLE_LIGHTS) terms.weight = terms.weight * c;
    if (what.importance == KILN_IMPORTANCE_NDF) {
        terms.weight = terms.weight * ggx_vndf_over_ndf(view, h, c);
        terms.deficit = K(1.0) - terms.weight;
    }
    if (what.terms & KILN_TERM_FRESNEL) {  // Schlick 1994; what rounding leaves below 0 stays 1e-35
        const real square = one_minus_VoH * one_minus_VoH;
        terms.fresnel = terms.weight * one_minus_VoH * (square * square);
    }
    return terms;
}
