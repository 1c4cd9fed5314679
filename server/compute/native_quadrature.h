// SPDX-License-Identifier: Apache-2.0
// The quadrature for one instruction set and one precision: included by native_isa.cpp behind
// native_kernels.h, into the same namespace.

constexpr int kGeneralFresnel = -1;

// A branch for the Fresnel models beyond Schlick's costs less than any of them.
template <int masking, int fresnel>
static void group_quadrature(const NativeQuadratureGroup<scalar>& group) {
    real NoV, alpha;
    for (int lane = 0; lane < KILN_LANES; ++lane) {
        NoV[lane] = group.NoV[lane];
        alpha[lane] = group.alpha[lane];
    }
    const int model = fresnel == kGeneralFresnel ? group.fresnel : fresnel;
    const Albedo albedo = quadrature(masking, model, group.parameters, NoV, alpha, group.nodes,
                                     group.order, group.azimuths);
    store(group.values, albedo.E);
    store(group.values + group.texel_stride, albedo.deficit);
    if (fresnel != KILN_FRESNEL_NONE) store(group.values + 2 * group.texel_stride, albedo.B);
}

static void group_quadrature_diffuse(const NativeQuadratureGroup<scalar>& group) {
    real NoV, alpha;
    for (int lane = 0; lane < KILN_LANES; ++lane) {
        NoV[lane] = group.NoV[lane];
        alpha[lane] = group.alpha[lane];
    }
    store(group.values, quadrature_diffuse(group.diffuse, group.fresnel, group.parameters, NoV,
                                           alpha, group.nodes, group.order, group.azimuths));
}

static NativeQuadrature<scalar> find_quadrature(int masking, int fresnel) {
    constexpr NativeQuadrature<scalar> functions[2][3] = {
        {group_quadrature<0, KILN_FRESNEL_NONE>, group_quadrature<0, KILN_FRESNEL_SCHLICK>,
         group_quadrature<0, kGeneralFresnel>},
        {group_quadrature<1, KILN_FRESNEL_NONE>, group_quadrature<1, KILN_FRESNEL_SCHLICK>,
         group_quadrature<1, kGeneralFresnel>}};
    return functions[masking][fresnel <= KILN_FRESNEL_SCHLICK ? fresnel : 2];
}
