// SPDX-License-Identifier: Apache-2.0
// Lights parted where total reflection begins. Inside a denser medium all is reflected up to a rim,
// VoH² = 1 − η², where F leaves 1 like a square root: an edge across the unit square, which N
// strata know to 1 / N. Here the rim is a side of the square, as the horizon is (visible_lights.h),
// and points are so dense towards the sides that a root becomes a line.
//
// The point is (cos φ, w, dw / dt, 1 − w) with w = t² (3 − 2 t).

// VoH² of the rim, and 1 less that: without total reflection 0 and 1. p: of fresnel_dielectric().
typedef struct {
    scalar cos2, sin2;
} Rim;

KILN_FUNCTION Rim total_reflection_rim(KILN_GLOBAL const scalar* p) {
    const int total = p[0] < K(0.0);
    const Rim rim = {total ? -p[0] : K(0.0), total ? p[1] : K(1.0)};
    return rim;
}

// The lights of an azimuth between two angles δ: sin²δ of both, cos²δ of the end without a
// subtraction.
typedef struct {
    real begin_sin2, end_sin2, end_cos2;
} Span;

// What of a span is before another's end.
KILN_FUNCTION Span span_before(Span span, real sin2, real cos2) {
    span.end_cos2 = lane_select(sin2 < span.end_sin2, cos2, span.end_cos2);
    span.end_sin2 = lane_min(span.end_sin2, sin2);
    span.begin_sin2 = lane_min(span.begin_sin2, span.end_sin2);
    return span;
}

// Of visible normals as visible_lights.h has them: with τ = tan δ, VoH² is above the rim where
// a τ² − 2 b τ < c. At δ = 0 it is where c > 0; else it may be between two roots.
KILN_FUNCTION Span transmitted_span(View view, scalar rim, real c, scalar cos_phi) {
    const real none = lanes(K(0.0)), one = lanes(K(1.0));
    const real spread = view.one_minus_alpha2 * (view.vx * view.vx);  // (1 − α²) vx²
    const real a = rim * lane_fma(spread, lanes(cos_phi * cos_phi), view.alpha * view.alpha);
    const real b = (rim * cos_phi) * (view.one_minus_alpha2 * view.vz * view.vx);
    const real square = lane_fma(a, c, b * b);
    const real sum = lane_sqrt(lane_max(square, none)) + lane_abs(b);
    const real along = lane_select(b > none, sum, lane_max(c, none));
    const real across = lane_select(b > none, a, sum);
    const real along2 = along * along, across2 = across * across, all = along2 + across2;
    const real inverse = one / lane_select(all >= KILN_TINY, all, one);
    const real before = lane_max(-c, none), before2 = before * before;
    const real from = lane_fma(sum, sum, before2);
    Span span;
    span.end_sin2 = lane_select(all >= KILN_TINY, along2 * inverse, one);
    span.end_cos2 = across2 * inverse;
    span.begin_sin2 = before2 / lane_select(from > none, from, one);
    // Neither is anywhere; along the horizon both round to what has no inverse.
    span.begin_sin2 = lane_select(lane_max(square, c) >= KILN_TINY, span.begin_sin2, span.end_sin2);
    return span;
}

// Of an empty span, which weighs 0, the light at δ = 45°: its ends need not be numbers, at α = 0 or
// along the horizon.
KILN_FUNCTION VisibleLight light_within(View view, Span span, KILN_GLOBAL const scalar* point) {
    const real width = span.end_sin2 - span.begin_sin2;
    const real none = lanes(K(0.0)), half_way = lanes(K(0.5));
    const real sin2 = lane_fma(width, lanes(point[1]), span.begin_sin2);
    const real cos2 = lane_fma(width, lanes(point[3]), span.end_cos2);
    const real sine = lane_sqrt(lane_select(width > none, sin2, half_way));
    const real cosine = lane_sqrt(lane_select(width > none, cos2, half_way));
    VisibleLight sample;
    sample.NoH = lane_fma(view.vz, cosine, -(view.vx * point[0]) * sine);
    sample.h.VoH2 = K(2.0) * cosine;
    sample.h.hh = lane_fma(view.one_minus_alpha2, sample.NoH * sample.NoH, view.alpha * view.alpha);
    sample.weight = width * (K(2.0) * view.inverse_cap) * point[2];
    return sample;
}

// Two samples of one point. Where c > 0 the reflected ones are those beyond the rim, and F weighs
// the transmitted ones; else they are all that there are, F = 1, and the transmitted ones weigh
// F − 1. So none is a small difference.
typedef struct {
    VisibleLight transmitted, reflected;
    real too_much;  // of the transmitted ones' F
} PartedLights;

KILN_FUNCTION PartedLights sample_parted_lights(View view, Rim rim,
                                                KILN_GLOBAL const scalar* point) {
    const real none = lanes(K(0.0)), one = lanes(K(1.0));
    // h of the stretched view itself, and what its VoH² has more than the rim, times both lengths.
    const real hh = lane_fma(view.one_minus_alpha2, view.vz * view.vz, view.alpha * view.alpha);
    const real c = lane_fma(view.S, view.S, -(rim.cos2 * hh));
    const Horizon horizon = visible_horizon(view, point[0]);
    Span span = transmitted_span(view, rim.cos2, c, point[0]);
    span = span_before(span, horizon.sin2, horizon.cos2);
    const Span rest = {lane_select(c > none, span.end_sin2, none), horizon.sin2, horizon.cos2};
    PartedLights lights;
    lights.transmitted = light_within(view, span, point);
    lights.reflected = light_within(view, rest, point);
    lights.too_much = lane_select(c > none, none, one);
    return lights;
}

// Of a diffuse lobe, the transmitted ones alone: even over the sphere about the view, to which
// their angle is twice δ. The azimuth about the view is 0 towards the normal.
typedef struct {
    Directions d;
    real weight;  // NoL / (π pdf)
} TransmittedLight;

KILN_FUNCTION TransmittedLight sample_transmitted_light(real NoV, Rim rim,
                                                        KILN_GLOBAL const scalar* point) {
    const real none = lanes(K(0.0)), one = lanes(K(1.0));
    TransmittedLight light;
    light.d.NoV = NoV;
    light.d.sinV = lane_sqrt((K(1.0) - NoV) * (K(1.0) + NoV));
    // At the horizon tan 2δ = −NoV / up.
    const real up = light.d.sinV * point[0];
    const real length = lane_sqrt(lane_fma(NoV, NoV, up * up));
    const real large = length + lane_abs(up);
    const real small = NoV * NoV / lane_select(large > none, large, one);
    const real part = K(0.5) / lane_select(length > none, length, one);
    const Span all = {none, lanes(rim.sin2), lanes(rim.cos2)};
    const Span span = span_before(all, part * lane_select(up > none, large, small),
                                  part * lane_select(up > none, small, large));
    const real sin2 = span.end_sin2 * point[1];
    const real cos2 = lane_fma(span.end_sin2, lanes(point[3]), span.end_cos2);
    const real sine = K(2.0) * lane_sqrt(sin2 * cos2), cosine = cos2 - sin2;  // of 2δ
    light.d.VoH = lane_sqrt(cos2);
    light.d.NoL = lane_saturate(lane_fma(cosine, NoV, sine * up));
    light.d.NoH = K(0.5) * (light.d.NoL + NoV) / light.d.VoH;
    const real along = lane_fma(cosine, light.d.sinV, -(point[0] * NoV) * sine);
    const scalar aside = (K(1.0) - point[0]) * (K(1.0) + point[0]);
    const real sinL2 = lane_fma(along, along, sine * sine * aside);
    light.d.sinL = lane_sqrt(sinL2);
    light.d.cos_phi =
        lane_select(sinL2 > none, along / lane_select(sinL2 > none, light.d.sinL, one), one);
    light.weight = light.d.NoL * span.end_sin2 * (K(4.0) * point[2]);
    return light;
}
