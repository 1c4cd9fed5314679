// SPDX-License-Identifier: Apache-2.0
// The sum of one batch: a run of points at one lane group of texels, always in the order of the
// points, in working precision. The host keeps batches short (kBatchPointsMax) and adds them in
// double.

// Scalars a point: three for the sampler (ggx.h), two products of theirs, which cost less on the
// host than in every lane, and NoV for averages.
#define KILN_POINT_SCALARS 6

// Points that are summed before their sum is added to the batch's, on every path alike. A smooth
// integrand rounds the same way at every addition: 1024 in a row lose 8e-6 of a constant 0.8 in
// float, two levels some 1e-6.
#define KILN_SUM_POINTS 64

// A sample goes through three stages, and each works KILN_AHEAD points behind the one before it. So
// the √ of one point, the products of another and the ÷ of a third stand side by side: none waits
// for its own, and divider and multipliers are busy together even where a neighbour on the core
// leaves half of its buffers. A stage takes some 50 cycles from its first operation to its last and
// a point some 17 of a core's time: two points ahead are too few. Where a real is one lane, on a
// GPU, other work-items hide the waiting.
#undef KILN_AHEAD
#undef KILN_SLOTS
#undef KILN_SLOT
#if KILN_LANES == 1
#define KILN_AHEAD 0
#define KILN_SLOTS 1
#define KILN_SLOT(i) 0
#else
#define KILN_AHEAD 4
#define KILN_SLOTS KILN_SUM_POINTS
#define KILN_SLOT(i) (i)
#endif

// What the stages hand over. `texel` is the view that stays the same; an average takes its own from
// every point.
typedef struct {
    View view[KILN_SLOTS];
    HalfVector h[KILN_SLOTS];
    Light light[KILN_SLOTS];
    real one_minus_VoH[KILN_SLOTS];
    real NoH[KILN_SLOTS], weight[KILN_SLOTS];  // where the points do not bring them
} Flight;

KILN_INLINED void take_half_vector(const Integrand what, const int averaged, const View texel,
                                   Flight* flight, KILN_GLOBAL const scalar* points, const int i) {
    KILN_GLOBAL const scalar* point = points + KILN_POINT_SCALARS * i;
    if (averaged)  // E_avg = ∫ E(√u) du: the view is part of the sample
        flight->view[KILN_SLOT(i)] = ggx_view(lanes(point[KILN_POINT_SCALARS - 1]), texel.alpha);
    const View view = averaged ? flight->view[KILN_SLOT(i)] : texel;
    if (what.importance < KILN_IMPORTANCE_HORIZON_NORMALS) {
        flight->h[KILN_SLOT(i)] = sample_half_vector(what, view, point);
    } else if (what.importance == KILN_IMPORTANCE_VISIBLE_LIGHTS) {
        const VisibleLight sample = sample_visible_light(view, point);
        flight->h[KILN_SLOT(i)] = sample.h;
        flight->NoH[KILN_SLOT(i)] = sample.NoH;
        flight->weight[KILN_SLOT(i)] = sample.weight;
    } else {
        const HorizonNormal sample = sample_horizon_normal(view, point);
        flight->h[KILN_SLOT(i)] = sample.h;
        flight->weight[KILN_SLOT(i)] = sample.inverse_NoH;
    }
}

KILN_INLINED void take_light(const Integrand what, const int averaged, const View texel,
                             Flight* flight, KILN_GLOBAL const scalar* points, const int i) {
    const View view = averaged ? flight->view[KILN_SLOT(i)] : texel;
    const HalfVector h = flight->h[KILN_SLOT(i)];
    real NoH = lanes(half_vector_NoH(what.importance, points + KILN_POINT_SCALARS * i));
    if (what.importance == KILN_IMPORTANCE_VISIBLE_LIGHTS) NoH = flight->NoH[KILN_SLOT(i)];
    flight->light[KILN_SLOT(i)] = ggx_mirror(view, h, NoH);
    if (what.terms & KILN_TERM_FRESNEL)
        flight->one_minus_VoH[KILN_SLOT(i)] = ggx_one_minus_VoH(view, h);
}

KILN_INLINED Terms add_sample(const Integrand what, const int averaged, const View texel,
                              const Flight* flight, KILN_GLOBAL const scalar* points, const int i,
                              Terms sum) {
    const View view = averaged ? flight->view[KILN_SLOT(i)] : texel;
    real one_minus_VoH = lanes(K(0.0));
    if (what.terms & KILN_TERM_FRESNEL) one_minus_VoH = flight->one_minus_VoH[KILN_SLOT(i)];
    real c = lanes(points[KILN_POINT_SCALARS * i + 2]);
    if (what.importance >= KILN_IMPORTANCE_HORIZON_NORMALS) c = flight->weight[KILN_SLOT(i)];
    const Terms terms =
        weigh(what, view, flight->h[KILN_SLOT(i)], flight->light[KILN_SLOT(i)], one_minus_VoH, c);
    sum.weight += terms.weight;
    sum.fresnel += terms.fresnel;
    sum.deficit += terms.deficit;
    return sum;
}

// The sum over at most KILN_SUM_POINTS points: filled, streaming, drained.
KILN_INLINED Terms stretch_sum(const Integrand what, const int averaged, const View texel,
                               Flight* flight, KILN_GLOBAL const scalar* points, const int count) {
    Terms sum = {lanes(K(0.0)), lanes(K(0.0)), lanes(K(0.0))};
    int i = 0;
    for (; i < 2 * KILN_AHEAD; ++i) {
        if (i < count) take_half_vector(what, averaged, texel, flight, points, i);
        if (i >= KILN_AHEAD && i - KILN_AHEAD < count)
            take_light(what, averaged, texel, flight, points, i - KILN_AHEAD);
    }
    for (; i < count; ++i) {
        take_half_vector(what, averaged, texel, flight, points, i);
        take_light(what, averaged, texel, flight, points, i - KILN_AHEAD);
        sum = add_sample(what, averaged, texel, flight, points, i - 2 * KILN_AHEAD, sum);
    }
    for (; i < count + 2 * KILN_AHEAD; ++i) {
        if (i - KILN_AHEAD < count)
            take_light(what, averaged, texel, flight, points, i - KILN_AHEAD);
        sum = add_sample(what, averaged, texel, flight, points, i - 2 * KILN_AHEAD, sum);
    }
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
