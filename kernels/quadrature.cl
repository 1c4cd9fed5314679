// SPDX-License-Identifier: Apache-2.0
// The OpenCL entry of the quadrature. One work-item owns KILN_LANES neighbouring texels.
// Specialised on KILN_FRESNEL and on the lobe: KILN_MASKING; KILN_DIFFUSE; or KILN_DISTRIBUTION,
// KILN_MASKING and KILN_TOTAL. KILN_QUADRATURE selects it among the entries, and the rule: 1 for
// quadrature(), 2 for quadrature_diffuse(), 3 for quadrature_lobe(), which say what the nodes are.
//   texels      NoV of every lane, then alpha of every lane: 2 × texel_stride
//   parameters  of the Fresnel term: KILN_FRESNEL_PARAMETERS; then the diffuse albedo
//   values      E, deficit, and B where KILN_FRESNEL, or the diffuse albedo: texel_stride each

#ifdef KILN_QUADRATURE
__kernel void quadrature_table(__global const scalar* texels, __global const scalar* nodes,
                               __global const scalar* parameters, const uint order,
                               const uint azimuths,
                               const uint texel_stride,
                               __global scalar* values) {
    const size_t group = get_global_id(0);
    const size_t lane_groups = texel_stride / KILN_LANES;
    __global const real* lane_texels = (__global const real*)texels;
    __global real* out = (__global real*)values + group;
#if KILN_QUADRATURE == 2
    out[0] = quadrature_diffuse(KILN_DIFFUSE, KILN_FRESNEL, parameters, lane_texels[group],
                                lane_texels[lane_groups + group], nodes, order, azimuths);
#else
#if KILN_QUADRATURE == 3
    const Lobe lobe = {KILN_DISTRIBUTION, KILN_MASKING, KILN_FRESNEL, KILN_TOTAL};
    const Albedo albedo = quadrature_lobe(lobe, parameters, lane_texels[group],
                                          lane_texels[lane_groups + group], nodes, order, azimuths);
#else
    const Albedo albedo = quadrature(KILN_MASKING, KILN_FRESNEL, parameters, lane_texels[group],
                                     lane_texels[lane_groups + group], nodes, order,
                                     azimuths);
#endif
    out[0] = albedo.E;
    out[lane_groups] = albedo.deficit;
    if (KILN_FRESNEL) out[2 * lane_groups] = albedo.B;
#endif
}
#endif
