// SPDX-License-Identifier: Apache-2.0
// The sum of one batch: a run of points at one lane group of texels, always in the order of the
// points, in working precision. The host keeps batches short (kBatchPointsMax) and adds them in
// double.

// Scalars a point: up to five that the sampler reads (ggx.h and others), products among them, which
// cost less on the host than in every lane, and NoV for averages.
#define KILN_POINT_SCALARS 6

// Points that are summed before their sum is added to the batch's, on every path alike. A smooth
// integrand rounds the same way at every addition: 1024 in a row lose 8e-6 of a constant 0.8 in
// float, two levels some 1e-6.
#define KILN_SUM_POINTS 64

// A sample goes through four stages, and each works KILN_AHEAD points behind the one before it. So
// the √ of one point, the products of the next two and the ÷ of a fourth stand side by side: none
// waits for its own, and divider and multipliers are busy together even where a neighbour on the
// core leaves half of its buffers. Under visible normals a stage takes some 35 cycles from its
// first operation to its last and a point some 14 of a core's time: two points ahead are too few,
// and eight were no faster. Where a real is one lane, on a GPU, other work-items hide the waiting.
#undef KILN_AHEAD
#undef KILN_SLOTS
#undef KILN_SLOT
#if KILN_LANES == 1
#define KILN_AHEAD 0
#define KILN_SLOTS 1
#define KILN_SLOT(i) (0 * (i))  // no index is left unread
#else
#define KILN_AHEAD 4
#define KILN_SLOTS KILN_SUM_POINTS
#define KILN_SLOT(i) (i)
#endif

// What the stages hand over, each importance its own part. An average takes its view from every
// point.
typedef struct {
    View view[KILN_SLOTS];
    real reach[KILN_SLOTS];       // ggx_cap_reach()
    Horizon horizon[KILN_SLOTS];  // of visible lights
    HalfVector h[KILN_SLOTS];
    Mirrored light[KILN_SLOTS];
    real S[KILN_SLOTS];
    real one_minus_VoH[KILN_SLOTS];
    real weight[KILN_SLOTS];  // where the points do not bring it
} Flight;

// An average's view, and the length that a half vector needs.
KILN_INLINED void take_aim(const Integrand what, const int averaged, const View texel,
                           Flight* flight, KILN_GLOBAL const scalar* points, const int i) {
    KILN_GLOBAL const scalar* point = points + KILN_POINT_SCALARS * i;
    if (averaged)  // E_avg = ∫ E(√u) du: the view is part of the sample
        flight->view[KILN_SLOT(i)] = ggx_view(lanes(point[KILN_POINT_SCALARS - 1]), texel.alpha);
    const View view = averaged ? flight->view[KILN_SLOT(i)] : texel;
    if (what.importance == KILN_IMPORTANCE_VNDF)
        flight->reach[KILN_SLOT(i)] = ggx_cap_reach(view, point);
    if (what.importance == KILN_IMPORTANCE_VISIBLE_LIGHTS)
        flight->horizon[KILN_SLOT(i)] = visible_horizon(view, point[0]);
}

// The half vector and the light but for its own length.
KILN_INLINED void take_light(const Integrand what, const int averaged, const View texel,
                             Flight* flight, KILN_GLOBAL const scalar* points, const int i) {
    KILN_GLOBAL const scalar* point = points + KILN_POINT_SCALARS * i;
    const View view = averaged ? flight->view[KILN_SLOT(i)] : texel;
    real NoH = lanes(half_vector_NoH(what.importance, point));
    HalfVector h;
    if (what.importance == KILN_IMPORTANCE_VNDF) {
        h = ggx_visible_normal(view, point, flight->reach[KILN_SLOT(i)]);
    } else if (what.importance == KILN_IMPORTANCE_VISIBLE_LIGHTS) {
        const VisibleLight sample = light_above(view, flight->horizon[KILN_SLOT(i)], point);
        h = sample.h;
        NoH = sample.NoH;
        flight->weight[KILN_SLOT(i)] = sample.weight;
    } else if (what.importance == KILN_IMPORTANCE_HORIZON_NORMALS) {
        const HorizonNormal sample = sample_horizon_normal(view, point);
        h = sample.h;
        flight->weight[KILN_SLOT(i)] = sample.inverse_NoH;
    } else {
        h = ggx_sample_ndf(view, point);
    }
    flight->light[KILN_SLOT(i)] = ggx_mirrored(view, h, NoH);
    // Compilers keep stores to an array that nobody reads.
    if (reads_half_vector(what)) flight->h[KILN_SLOT(i)] = h;
}

KILN_INLINED void take_lengths(const Integrand what, const int averaged, const View texel,
                               Flight* flight, const int i) {
    flight->S[KILN_SLOT(i)] = lane_root(flight->light[KILN_SLOT(i)].S2);
    if (!(what.terms & KILN_TERM_FRESNEL)) return;
    const View view = averaged ? flight->view[KILN_SLOT(i)] : texel;
    flight->one_minus_VoH[KILN_SLOT(i)] = ggx_one_minus_VoH(view, flight->h[KILN_SLOT(i)]);
}

KILN_INLINED Terms add_sample(const Integrand what, const int averaged, const View texel,
                              const Flight* flight, KILN_GLOBAL const scalar* points, const int i,
                              Terms sum) {
    const View view = averaged ? flight->view[KILN_SLOT(i)] : texel;
    const Light light = {flight->light[KILN_SLOT(i)].NoL, flight->S[KILN_SLOT(i)]};
    HalfVector h = {lanes(K(0.0)), lanes(K(0.0))};
    if (reads_half_vector(what)) h = flight->h[KILN_SLOT(i)];
    real one_minus_VoH = lanes(K(0.0));
    if (what.terms & KILN_TERM_FRESNEL) one_minus_VoH = flight->one_minus_VoH[KILN_SLOT(i)];
    real c = lanes(points[KILN_POINT_SCALARS * i + 2]);
    if (what.importance >= KILN_IMPORTANCE_HORIZON_NORMALS) c = flight->weight[KILN_SLOT(i)];
    const Terms terms = weigh(what, view, h, light, one_minus_VoH, c);
    sum.weight += terms.weight;
    sum.fresnel += terms.fresnel;
    sum.deficit += terms.deficit;
    return sum;
}

// All stages, the first of them at point i of `count`: where not `streaming`, some have none to
// work at.
KILN_INLINED Terms stages_at(const Integrand what, const int averaged, const View texel,
                             Flight* flight, KILN_GLOBAL const scalar* points, const int streaming,
                             const int i, const int count, Terms sum) {
    const int second = i - KILN_AHEAD, third = second - KILN_AHEAD, last = third - KILN_AHEAD;
    if (streaming || i < count) take_aim(what, averaged, texel, flight, points, i);
    if (streaming || (second >= 0 && second < count))
        take_light(what, averaged, texel, flight, points, second);
    if (streaming || (third >= 0 && third < count))
        take_lengths(what, averaged, texel, flight, third);
    if (streaming || (last >= 0 && last < count))
        sum = add_sample(what, averaged, texel, flight, points, last, sum);
    return sum;
}

// The sum over at most KILN_SUM_POINTS points: filled, streaming, drained.
KILN_INLINED Terms stretch_sum(const Integrand what, const int averaged, const View texel,
                               Flight* flight, KILN_GLOBAL const scalar* points, const int count) {
    Terms sum = {lanes(K(0.0)), lanes(K(0.0)), lanes(K(0.0))};
    int i = 0;
    for (; i < 3 * KILN_AHEAD; ++i)
        sum = stages_at(what, averaged, texel, flight, points, 0, i, count, sum);
    for (; i < count; ++i) sum = stages_at(what, averaged, texel, flight, points, 1, i, count, sum);
    for (; i < count + 3 * KILN_AHEAD; ++i)
        sum = stages_at(what, averaged, texel, flight, points, 0, i, count, sum);
    return sum;
}

KILN_INLINED Terms batch_sum(const Integrand what, const int averaged, const View texel,
                             KILN_GLOBAL const scalar* points, const unsigned int point_count) {
    Terms all = {lanes(K(0.0)), lanes(K(0.0)), lanes(K(0.0))};
    Flight flight;
    for (unsigned int first = 0; first < point_count; first += KILN_SUM_POINTS) {
        const unsigned int left = point_count - first;
        const int count = left < KILN_SUM_POINTS ? (int)left : KILN_SUM_POINTS;
        const Terms sum =
            stretch_sum(what, averaged, texel, &flight, points + KILN_POINT_SCALARS * first, count);
        all.weight += sum.weight;
        all.fresnel += sum.fresnel;
        all.deficit += sum.deficit;
    }
    return all;
}
