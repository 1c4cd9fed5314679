// SPDX-License-Identifier: Apache-2.0
// The quadrature for one instruction set and one precision: included by native_isa.cpp behind
// native_kernels.h, into the same namespace.

template <int masking, int fresnel>
static void group_quadrature(const NativeQuadratureGroup<scalar>& group) {
    real NoV, alpha;
    for (int lane = 0; lane < KILN_LANES; ++lane) {
        NoV[lane] = group.NoV[lane];
        alpha[lane] = group.alpha[lane];
    }
    const Albedo albedo = quadrature(masking, fresnel, NoV, alpha, group.nodes, group.order);
    store(group.values, albedo.E);
    store(group.values + group.texel_stride, albedo.deficit);
    if (fresnel) store(group.values + 2 * group.texel_stride, albedo.B);
}

static NativeQuadrature<scalar> find_quadrature(int masking, int fresnel) {
    constexpr NativeQuadrature<scalar> functions[2][2] = {
        {group_quadrature<0, 0>, group_quadrature<0, 1>},
        {group_quadrature<1, 0>, group_quadrature<1, 1>}};
    return functions[masking][fresnel];
}
