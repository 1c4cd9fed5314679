// SPDX-License-Identifier: Apache-2.0
// The OpenCL entry. One work-item owns KILN_LANES neighbouring texels and walks the batches of a
// launch. Specialised on what is asked by the closed set KILN_DISTRIBUTION, KILN_MASKING,
// KILN_IMPORTANCE, KILN_TERMS, KILN_AVERAGED, KILN_FRESNEL, KILN_DIFFUSE, KILN_GENERAL; sizes,
// counts, points and the numbers of the material are arguments. KILN_ANY_MATERIAL, of the general
// path alone, reads the set from `material` instead: one program for all, as native code has one
// function, slow and soon compiled.
//   material    of KILN_ANY_MATERIAL; else passed over
//   texels      NoV of every lane, then alpha of every lane: 2 × texel_stride
//   points      material_point_scalars() a point, on the fast path KILN_POINT_SCALARS
//   parameters  KILN_PARAMETER_COUNT
//   batches     first point, point count: batch_count pairs
//   sums        [batch][term that is asked for][texel_stride]

#if !defined(KILN_QUADRATURE) && !defined(KILN_MEASURED)
__kernel void tables(__global const scalar* texels, __global const scalar* points,
                     __global const scalar* parameters, __global const uint* batches,
                     const uint batch_count, const uint texel_stride, const Material material,
                     __global scalar* sums) {
    const size_t group = get_global_id(0);
    const size_t lane_groups = texel_stride / KILN_LANES;
    __global const real* lane_texels = (__global const real*)texels;
    const real NoV = lane_texels[group], alpha = lane_texels[lane_groups + group];
    __global real* out = (__global real*)sums + group;
#if KILN_ANY_MATERIAL
    const Material what = material;
#elif KILN_GENERAL
    const Material what = {KILN_DISTRIBUTION, KILN_MASKING,  KILN_IMPORTANCE, KILN_TERMS,
                           KILN_AVERAGED,     KILN_FRESNEL, KILN_DIFFUSE};
#else
    const Integrand what = {KILN_MASKING, KILN_IMPORTANCE, KILN_TERMS};
    const View view = ggx_view(NoV, alpha);
#endif
    for (uint b = 0; b < batch_count; ++b) {
        const uint first = batches[2 * b], count = batches[2 * b + 1];
#if KILN_GENERAL
        const Sums sum = material_sum(what, parameters, NoV, alpha, points, first, count);
        for (int t = 0; t < KILN_TERM_COUNT; ++t)
            if (what.terms >> t & 1) { *out = sum.term[t]; out += lane_groups; }
#else
        const Terms sum = batch_sum(what, KILN_AVERAGED, view,
                                    points + (size_t)KILN_POINT_SCALARS * first, count);
        if (KILN_TERMS & KILN_TERM_WEIGHT) { *out = sum.weight; out += lane_groups; }
        if (KILN_TERMS & KILN_TERM_FRESNEL) { *out = sum.fresnel; out += lane_groups; }
        if (KILN_TERMS & KILN_TERM_DEFICIT) { *out = sum.deficit; out += lane_groups; }
#endif
    }
}
#endif
