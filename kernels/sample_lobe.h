// SPDX-License-Identifier: Apache-2.0
// What one sample of any specular lobe contributes, without its Fresnel term.

typedef struct {
    int distribution, masking, importance, terms, averaged;
    int fresnel, diffuse;
} Material;

// GGX under Smith from half vectors: the fast path's own lobe, with its exact deficit.
KILN_FUNCTION int is_fast_lobe(const Material what) {
    return what.distribution == KILN_DISTRIBUTION_GGX &&
           what.masking <= KILN_MASKING_SMITH_SEPARABLE &&
           (what.importance <= KILN_IMPORTANCE_NDF ||
            what.importance >= KILN_IMPORTANCE_VISIBLE_LIGHTS);
}

// {f NoL / pdf, VoH, 1 − that without the subtraction where the lobe knows how}, of a half vector
// that the importance has drawn.
KILN_FUNCTION Terms weigh_fast(const Material what, View view, VisibleLight sample, real* VoH) {
    const Integrand fast = {what.masking, what.importance,
                            what.terms & (KILN_TERM_WEIGHT | KILN_TERM_DEFICIT)};
    *VoH = ggx_VoH(view, sample.h);
    return weigh(fast, view, sample.h, ggx_mirror(view, sample.h, sample.NoH), *VoH, sample.weight);
}

KILN_FUNCTION Terms weigh_scattering(const Material what, View view, Scattering s) {
    const real none = lanes(K(0.0));
    // A light below the horizon must not reach the visibility: its denominators may vanish there.
    const real NoL = s.NoL;
    s.sinL = lane_select(NoL > none, s.sinL, none);
    s.NoL = lane_select(NoL > none, NoL, lanes(K(1.0)));
    const real weight =
        microfacet_product(what.distribution, what.masking, view.alpha, s, s.factor);
    Terms terms;
    terms.weight = lane_select(NoL > none, weight, none);
    terms.fresnel = none;
    terms.deficit = K(1.0) - terms.weight;
    return terms;
}

KILN_CALLED Terms sample_lobe(const Material what, View view, KILN_GLOBAL const scalar* point,
                              real* VoH) {
    if (is_fast_lobe(what)) {
        VisibleLight sample;
        if (what.importance == KILN_IMPORTANCE_VISIBLE_LIGHTS) {
            sample = sample_visible_light(view, point);
        } else {
            sample.h = what.importance == KILN_IMPORTANCE_NDF ? ggx_sample_ndf(view, point)
                                                              : ggx_sample_vndf(view, point);
            sample.NoH = lanes(half_vector_NoH(what.importance, point));
            sample.weight = lanes(point[2]);
        }
        return weigh_fast(what, view, sample, VoH);
    }
    Scattering s;
    const real NoH = lanes(half_vector_NoH(what.importance, point));
    if (what.importance >= KILN_IMPORTANCE_COSINE) {
        s = scatter_hemisphere(what.importance, view.NoV, point[0], point[1], point[2]);
        s.factor = s.factor * microfacet_D(what.distribution, view.alpha, s.NoV, s.NoH, s.sin2_H);
    } else if (what.importance == KILN_IMPORTANCE_VNDF) {
        const HalfVector h = ggx_sample_vndf(view, point);
        s = scatter_half_vector(what.importance, view, h, NoH);
        if (what.distribution == KILN_DISTRIBUTION_BECKMANN)
            s.factor = s.factor * beckmann_over_ggx(visible_normal_spread(view, h, point));
    } else if (what.distribution == KILN_DISTRIBUTION_BECKMANN) {
        s = scatter_half_vector(what.importance, view, beckmann_sample_ndf(view, point), NoH);
    } else {
        s = scatter_half_vector(what.importance, view, ggx_sample_ndf(view, point), NoH);
    }
    *VoH = s.VoH;
    return weigh_scattering(what, view, s);
}

// f NoL / pdf of a light that has a weight of its own.
KILN_CALLED real weigh_light(const Material what, View view, VisibleLight sample, real* VoH) {
    if (is_fast_lobe(what)) return weigh_fast(what, view, sample, VoH).weight;
    Scattering s = scatter_half_vector(KILN_IMPORTANCE_VNDF, view, sample.h, sample.NoH);
    if (what.distribution == KILN_DISTRIBUTION_BECKMANN)
        s.factor = s.factor *
                   beckmann_over_ggx(K(1.0) / lane_max(sample.NoH * sample.NoH, lanes(K(1e-3))));
    *VoH = s.VoH;
    s.factor = s.factor * sample.weight;
    return weigh_scattering(what, view, s).weight;
}
