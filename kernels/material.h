// SPDX-License-Identifier: Apache-2.0
// The general path: any lobe, Fresnel and diffuse model that the fast path (integrand.h, batch.h)
// does not know, one point after the other.

// Beside the terms of integrand.h. A coloured one is three sums, R G B, from its first on.
#define KILN_FIRST_COLOUR 3
#define KILN_FIRST_DIFFUSE 6
#define KILN_FIRST_TRANSMITTED 9
#define KILN_TERM_COLOUR (1 << KILN_FIRST_COLOUR)    // F(VoH) f NoL / pdf
#define KILN_TERM_DIFFUSE (1 << KILN_FIRST_DIFFUSE)  // π f_d under cosine sampling: the albedo
#define KILN_TERM_TRANSMITTED (1 << KILN_FIRST_TRANSMITTED)  // (1 − F(VoH)) π f_d
#define KILN_TERM_COUNT 12
#define KILN_TERMS_DIFFUSE (7 * KILN_TERM_DIFFUSE | 7 * KILN_TERM_TRANSMITTED)

// Numbers of the job, uniform over a launch: Fresnel's of each channel, the diffuse albedo of each
// channel, Schlick's exponent of the split sum.
#define KILN_PARAMETER_ALBEDO (3 * KILN_FRESNEL_PARAMETERS)
#define KILN_PARAMETER_EXPONENT (KILN_PARAMETER_ALBEDO + 3)
#define KILN_PARAMETER_COUNT (KILN_PARAMETER_EXPONENT + 1)

typedef struct {
    real term[KILN_TERM_COUNT];
} Sums;

// Of a half vector that faces away from the view the weight is 0, and must not meet 2^exponent = ∞.
KILN_CALLED real fresnel_power(real VoH, scalar exponent) {
    return lane_pow_one_minus(lane_saturate(VoH), lanes(exponent));
}

// Sums go by address: by value, PoCL copies all of them twice a sample.
KILN_FUNCTION void diffuse_sums(const Material what, KILN_GLOBAL const scalar* p, real NoV,
                                real roughness, KILN_GLOBAL const scalar* point, Sums* sums) {
    const Directions d = diffuse_directions(NoV, lanes(point[1]), lanes(point[2]), point[0]);
    for (int c = 0; c < 3; ++c) {
        const int diffuse = KILN_TERM_DIFFUSE << c, transmitted = KILN_TERM_TRANSMITTED << c;
        if (!(what.terms & (diffuse | transmitted))) continue;
        const real lobe = diffuse_lobe(what.diffuse, d, roughness, p[KILN_PARAMETER_ALBEDO + c]);
        if (what.terms & diffuse) sums->term[KILN_FIRST_DIFFUSE + c] += lobe;
        if (what.terms & transmitted)
            sums->term[KILN_FIRST_TRANSMITTED + c] +=
                lobe * (K(1.0) - fresnel(what.fresnel, p + KILN_FRESNEL_PARAMETERS * c, d.VoH));
    }
}

// What F weighs with a kink, by lights of its own (parted_lights.h).
KILN_FUNCTION void parted_sums(const Material what, KILN_GLOBAL const scalar* p, View view,
                               real roughness, KILN_GLOBAL const scalar* point, Sums* sums) {
    for (int c = 0; c < 3; ++c) {
        KILN_GLOBAL const scalar* numbers = p + KILN_FRESNEL_PARAMETERS * c;
        const Rim rim = total_reflection_rim(numbers);
        if (what.terms & (KILN_TERM_COLOUR << c)) {
            const PartedLights lights = sample_parted_lights(view, rim, point);
            real VoH;
            const real reflected = weigh_light(what, view, lights.reflected, &VoH);
            const real transmitted = weigh_light(what, view, lights.transmitted, &VoH);
            const real F = fresnel(what.fresnel, numbers, VoH) - lights.too_much;
            sums->term[KILN_FIRST_COLOUR + c] += lane_fma(F, transmitted, reflected);
        }
        if (what.terms & (KILN_TERM_TRANSMITTED << c)) {
            const TransmittedLight light = sample_transmitted_light(view.NoV, rim, point);
            const real lobe =
                diffuse_lobe(what.diffuse, light.d, roughness, p[KILN_PARAMETER_ALBEDO + c]);
            sums->term[KILN_FIRST_TRANSMITTED + c] +=
                light.weight * lobe * (K(1.0) - fresnel(what.fresnel, numbers, light.d.VoH));
        }
    }
}

KILN_FUNCTION void specular_sums(const Material what, KILN_GLOBAL const scalar* p, View view,
                                 KILN_GLOBAL const scalar* point, Sums* sums) {
    real VoH;
    const Terms lobe = sample_lobe(what, view, point, &VoH);
    // Of a mirror it is NoV: Schlick's powers below 1 feel what a root rounds 1 to.
    VoH = lane_select(view.alpha > K(0.0), VoH, view.NoV);
    if (what.terms & KILN_TERM_WEIGHT) sums->term[0] += lobe.weight;
    if (what.terms & KILN_TERM_FRESNEL)
        sums->term[1] += lobe.weight * fresnel_power(VoH, p[KILN_PARAMETER_EXPONENT]);
    if (what.terms & KILN_TERM_DEFICIT) sums->term[2] += lobe.deficit;
    for (int c = 0; c < 3; ++c)
        if (what.terms & (KILN_TERM_COLOUR << c))
            sums->term[KILN_FIRST_COLOUR + c] +=
                lobe.weight * fresnel(what.fresnel, p + KILN_FRESNEL_PARAMETERS * c, VoH);
}

KILN_FUNCTION Sums no_sums(void) {
    Sums sums;
    for (int t = 0; t < KILN_TERM_COUNT; ++t) sums.term[t] = lanes(K(0.0));
    return sums;
}

KILN_FUNCTION int walks(const Material what) {
    return what.diffuse == KILN_DIFFUSE_GGX_LAMBERT && (what.terms & KILN_TERMS_DIFFUSE) != 0;
}

// Scalars of a point; NoV of averages is the last.
KILN_FUNCTION unsigned int material_point_scalars(const Material what) {
    return walks(what) ? KILN_WALK_SCALARS : KILN_POINT_SCALARS;
}

// As batch_sum() of batch.h, of the batch that starts at `first_point`. Averages take NoV from
// every point.
KILN_FUNCTION Sums material_sum(const Material what, KILN_GLOBAL const scalar* p, real NoV,
                                real alpha, KILN_GLOBAL const scalar* points,
                                const unsigned int first_point, const unsigned int point_count) {
    Sums all = no_sums(), sums = no_sums();
    const real roughness = lane_sqrt(alpha);
    // Narrower lobes than these, 1e-15 in float, count as the mirror: near the horizon the products
    // of two cosines of their half vectors are no numbers, nor is D V of a light. The fast path
    // needs neither.
    if (!is_fast_lobe(what))
        alpha = lane_select(alpha > K(1e3) * KILN_ROOT_TINY, alpha, lanes(K(0.0)));
    View view = ggx_view(NoV, alpha);
    const unsigned int scalars = material_point_scalars(what);
    KILN_GLOBAL const scalar* batch = points + (unsigned long)scalars * first_point;
    for (unsigned int i = 0; i < point_count; ++i) {
        KILN_GLOBAL const scalar* point = batch + scalars * i;
        if (what.averaged) {
            NoV = lanes(point[scalars - 1]);
            view = ggx_view(NoV, alpha);
        }
        if (walks(what)) {
            const Walked walked =
                ggx_lambert_walk(what.terms >> KILN_FIRST_DIFFUSE & 7, p + KILN_PARAMETER_ALBEDO,
                                 view, batch, i, first_point, point_count);
            for (int c = 0; c < 3; ++c) sums.term[KILN_FIRST_DIFFUSE + c] += walked.albedo[c];
        } else if (what.importance == KILN_IMPORTANCE_PARTED_LIGHTS)
            parted_sums(what, p, view, roughness, point, &sums);
        else if (what.terms & KILN_TERMS_DIFFUSE)
            diffuse_sums(what, p, NoV, roughness, point, &sums);
        else
            specular_sums(what, p, view, point, &sums);
        if ((i + 1) % KILN_SUM_POINTS != 0 && i + 1 != point_count) continue;
        for (int t = 0; t < KILN_TERM_COUNT; ++t) all.term[t] += sums.term[t];
        sums = no_sums();
    }
    return all;
}
