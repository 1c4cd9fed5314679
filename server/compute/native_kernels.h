// SPDX-License-Identifier: Apache-2.0
// The kernels for one instruction set and one precision. Included by native_isa.cpp, which is
// compiled once an -march, inside a namespace of its own, with `Register`, `RegisterBits`,
// `scalar`, KILN_LANES and KILN_DOUBLE set. No standard header may be included here: an inline
// function compiled under a wide -march could be linked into code that runs everywhere.

using real = Register;
__attribute__((always_inline)) static inline real lane_sqrt(real x) { return register_sqrt(x); }
__attribute__((always_inline)) static inline real lane_fma(real a, real b, real c) {
    return register_fma(a, b, c);
}
#undef KILN_AS_BITS
#undef KILN_AS_REAL
#define KILN_AS_BITS(x) ((RegisterBits)(x))
#define KILN_AS_REAL(x) ((real)(x))

#include "kernels/kernels.h"

static void store(scalar* to, real value) {
    for (int lane = 0; lane < KILN_LANES; ++lane) to[lane] = value[lane];
}

template <int masking, int importance, int terms, int averaged>
static void group_sums(const NativeGroup<scalar>& group) {
    const Integrand what = {masking, importance, terms};
    real NoV, alpha;
    for (int lane = 0; lane < KILN_LANES; ++lane) {
        NoV[lane] = group.NoV[lane];
        alpha[lane] = group.alpha[lane];
    }
    const View view = ggx_view(NoV, alpha);
    scalar* out = group.sums;
    for (unsigned b = 0; b < group.batch_count; ++b) {
        const BatchRange batch = group.batches[b];
        const Terms sum =
            batch_sum(what, averaged, view,
                      group.points + (unsigned long)KILN_POINT_SCALARS * batch.first_point,
                      batch.point_count);
        if (terms & KILN_TERM_WEIGHT) store(out, sum.weight), out += group.texel_stride;
        if (terms & KILN_TERM_FRESNEL) store(out, sum.fresnel), out += group.texel_stride;
        if (terms & KILN_TERM_DEFICIT) store(out, sum.deficit), out += group.texel_stride;
    }
}

// Rows: masking, importance; within a row the term sets 1…7 at a fixed view, then those averaged.
template <int masking, int importance>
struct Row {
    static constexpr NativeFunction<scalar> functions[2][8] = {
        {nullptr, group_sums<masking, importance, 1, 0>, group_sums<masking, importance, 2, 0>,
         group_sums<masking, importance, 3, 0>, group_sums<masking, importance, 4, 0>,
         group_sums<masking, importance, 5, 0>, group_sums<masking, importance, 6, 0>,
         group_sums<masking, importance, 7, 0>},
        {nullptr, group_sums<masking, importance, 1, 1>, group_sums<masking, importance, 2, 1>,
         group_sums<masking, importance, 3, 1>, group_sums<masking, importance, 4, 1>,
         group_sums<masking, importance, 5, 1>, group_sums<masking, importance, 6, 1>,
         group_sums<masking, importance, 7, 1>}};
};

// The general path, once for all materials: a branch that is the same for every sample costs less
// than any of the terms behind it.
static void material_sums(const NativeGroup<scalar>& group) {
    const KernelMaterial& m = group.material;
    const Material what = {m.distribution, m.masking, m.importance, m.terms,
                           m.averaged,     m.fresnel, m.diffuse};
    real NoV, alpha;
    for (int lane = 0; lane < KILN_LANES; ++lane) {
        NoV[lane] = group.NoV[lane];
        alpha[lane] = group.alpha[lane];
    }
    scalar* out = group.sums;
    for (unsigned b = 0; b < group.batch_count; ++b) {
        const BatchRange batch = group.batches[b];
        const Sums sums = material_sum(what, group.parameters, NoV, alpha, group.points,
                                       batch.first_point, batch.point_count);
        for (int t = 0; t < KILN_TERM_COUNT; ++t)
            if (what.terms >> t & 1) store(out, sums.term[t]), out += group.texel_stride;
    }
}

static NativeFunction<scalar> find(const KernelMaterial& what) {
    if (what.general) return material_sums;
    if (what.importance == KILN_IMPORTANCE_LOG_TANGENTS) {
        constexpr int log_tangents = KILN_IMPORTANCE_LOG_TANGENTS, deficit = KILN_TERM_DEFICIT;
        constexpr const NativeFunction<scalar> functions[2] = {
            group_sums<0, log_tangents, deficit, 0>, group_sums<1, log_tangents, deficit, 0>};
        return functions[what.masking];
    }
    if (what.importance == KILN_IMPORTANCE_HORIZON_NORMALS) {  // averages alone
        constexpr int horizon = KILN_IMPORTANCE_HORIZON_NORMALS, deficit = KILN_TERM_DEFICIT;
        constexpr const NativeFunction<scalar> functions[2] = {group_sums<0, horizon, deficit, 1>,
                                                               group_sums<1, horizon, deficit, 1>};
        return functions[what.masking];
    }
    if (what.importance == KILN_IMPORTANCE_VISIBLE_LIGHTS) {  // weights and Schlick's term alone
        constexpr int lights = KILN_IMPORTANCE_VISIBLE_LIGHTS;
        constexpr const NativeFunction<scalar> functions[2][4] = {
            {nullptr, group_sums<0, lights, 1, 0>, group_sums<0, lights, 2, 0>,
             group_sums<0, lights, 3, 0>},
            {nullptr, group_sums<1, lights, 1, 0>, group_sums<1, lights, 2, 0>,
             group_sums<1, lights, 3, 0>}};
        return functions[what.masking][what.terms];
    }
    constexpr const NativeFunction<scalar>(*rows[2][2])[8] = {
        {Row<0, 0>::functions, Row<0, 1>::functions}, {Row<1, 0>::functions, Row<1, 1>::functions}};
    return rows[what.masking][what.importance][what.averaged][what.terms];
}
