// SPDX-License-Identifier: Apache-2.0
// The quadrature for one instruction set and one precision: included by native_isa.cpp behind
// native_kernels.h, into the same namespace.

constexpr int kGeneralFresnel = -1;

struct Place {
    real NoV, alpha;
};
static Place place_of(const NativeQuadratureGroup<scalar>& group) {
    Place at;
    for (int lane = 0; lane < KILN_LANES; ++lane) {
        at.NoV[lane] = group.NoV[lane];
        at.alpha[lane] = group.alpha[lane];
    }
    return at;
}

static void store_albedo(const NativeQuadratureGroup<scalar>& group, int model,
                         const Albedo& albedo) {
    store(group.values, albedo.E);
    store(group.values + group.texel_stride, albedo.deficit);
    if (model != KILN_FRESNEL_NONE) store(group.values + 2 * group.texel_stride, albedo.B);
}

// A branch for the Fresnel models beyond Schlick's costs less than any of them.
template <int masking, int fresnel>
static void group_quadrature(const NativeQuadratureGroup<scalar>& group) {
    const Place at = place_of(group);
    const int model = fresnel == kGeneralFresnel ? group.what.fresnel : fresnel;
    const Albedo albedo = quadrature(masking, model, group.parameters, at.NoV, at.alpha,
                                     group.nodes, group.order, group.azimuths);
    store_albedo(group, model, albedo);
}

// One copy of it for all lobes: the branches are the same in all lanes and at all nodes.
static void group_quadrature_lobe(const NativeQuadratureGroup<scalar>& group) {
    const Place at = place_of(group);
    const QuadratureNumbers& numbers = group.what;
    const Lobe lobe = {numbers.distribution, numbers.masking, numbers.fresnel,
                       numbers.total_reflection};
    store_albedo(group, lobe.fresnel,
                 quadrature_lobe(lobe, group.parameters, at.NoV, at.alpha, group.nodes, group.order,
                                 group.azimuths));
}

static void group_quadrature_diffuse(const NativeQuadratureGroup<scalar>& group) {
    const Place at = place_of(group);
    store(group.values,
          quadrature_diffuse(group.what.diffuse, group.what.fresnel, group.parameters, at.NoV,
                             at.alpha, group.nodes, group.order, group.azimuths));
}

static NativeQuadrature<scalar> find_quadrature(const QuadratureNumbers& what) {
    constexpr NativeQuadrature<scalar> smith[2][3] = {
        {group_quadrature<0, KILN_FRESNEL_NONE>, group_quadrature<0, KILN_FRESNEL_SCHLICK>,
         group_quadrature<0, kGeneralFresnel>},
        {group_quadrature<1, KILN_FRESNEL_NONE>, group_quadrature<1, KILN_FRESNEL_SCHLICK>,
         group_quadrature<1, kGeneralFresnel>}};
    if (what.rule == QuadratureNumbers::Rule::lobe) return group_quadrature_lobe;
    if (what.rule == QuadratureNumbers::Rule::diffuse) return group_quadrature_diffuse;
    return smith[what.masking][what.fresnel <= KILN_FRESNEL_SCHLICK ? what.fresnel : 2];
}
