// SPDX-License-Identifier: Apache-2.0
// The sum of one batch: a run of points at one lane group of texels, always in the order of the
// points, in working precision. The host keeps batches short (kBatchPointsMax) and adds them in
// double.

// Four scalars a point: three for the sampler of half vectors (ggx.h), and NoV for averages.
#define KILN_POINT_SCALARS 4

// Points in flight: each stage runs over a stretch of points before the next one starts, so that
// the dependent √ … √ … ÷ of one point never fill the scheduler of a CPU while the divider waits,
// and so that each stage has fewer other operations than the divider has time for. A GPU hides that
// behind other work-items.
#undef KILN_STRETCH
#ifdef KILN_GPU
#define KILN_STRETCH 1
#else
#define KILN_STRETCH 64
#endif

// Points that are summed before their sum is added to the batch's, on every path alike. A smooth
// integrand rounds the same way at every addition: 1024 in a row lose 8e-6 of a constant 0.8 in
// float, two levels some 1e-6.
#define KILN_SUM_POINTS 64

// `texel` is the view that stays the same over batches; an average takes its own from every point.
KILN_FUNCTION Terms batch_sum(const Integrand what, const int averaged, const View texel,
                              KILN_GLOBAL const scalar* points, const unsigned int point_count) {
    const Terms none = {lanes(K(0.0)), lanes(K(0.0)), lanes(K(0.0))};
    Terms all = none, sum = none;
    View view[KILN_STRETCH];
    HalfVector h[KILN_STRETCH];
    Light light[KILN_STRETCH];
    real VoH[KILN_STRETCH];
    view[0] = texel;
    for (unsigned int first = 0; first < point_count; first += KILN_STRETCH) {
        const unsigned int left = point_count - first;
        const unsigned int count = left < KILN_STRETCH ? left : KILN_STRETCH;
        KILN_GLOBAL const scalar* point = points + KILN_POINT_SCALARS * first;
        if (averaged)  // E_avg = ∫ E(√u) du: the view is part of the sample
            for (unsigned int i = 0; i < count; ++i)
                view[i] = ggx_view(lanes(point[KILN_POINT_SCALARS * i + 3]), texel.alpha);
        for (unsigned int i = 0; i < count; ++i)
            h[i] = sample_half_vector(what, view[averaged ? i : 0], point[KILN_POINT_SCALARS * i],
                                      point[KILN_POINT_SCALARS * i + 1],
                                      point[KILN_POINT_SCALARS * i + 2]);
        for (unsigned int i = 0; i < count; ++i) {
            light[i] = ggx_mirror(view[averaged ? i : 0], h[i]);
            VoH[i] = lanes(K(0.0));
            if (what.terms & KILN_TERM_FRESNEL) VoH[i] = ggx_VoH(view[averaged ? i : 0], h[i]);
        }
        for (unsigned int i = 0; i < count; ++i) {
            const Terms terms = weigh(what, view[averaged ? i : 0], h[i], light[i], VoH[i],
                                      point[KILN_POINT_SCALARS * i + 2]);
            sum.weight += terms.weight;
            sum.fresnel += terms.fresnel;
            sum.deficit += terms.deficit;
        }
        if ((first + count) % KILN_SUM_POINTS != 0 && first + count != point_count) continue;
        all.weight += sum.weight;
        all.fresnel += sum.fresnel;
        all.deficit += sum.deficit;
        sum = none;
    }
    return all;
}
