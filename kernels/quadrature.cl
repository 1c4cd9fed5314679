// SPDX-License-Identifier: Apache-2.0
// The OpenCL entry of the quadrature. One work-item owns KILN_LANES neighbouring texels.
// Specialised on KILN_FRESNEL and on KILN_MASKING, the lobe's, or KILN_DIFFUSE, the diffuse lobe's
// number; KILN_QUADRATURE selects it among the entries, 1 for the lobe, 2 for a diffuse one.
//   texels      NoV of every lane, then alpha of every lane: 2 × texel_stride
//   nodes       see quadrature(), quadrature_diffuse()
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
    const Albedo albedo = quadrature(KILN_MASKING, KILN_FRESNEL, parameters, lane_texels[group],
                                     lane_texels[lane_groups + group], nodes, order,
                                     azimuths);
    out[0] = albedo.E;
    out[lane_groups] = albedo.deficit;
    if (KILN_FRESNEL) out[2 * lane_groups] = albedo.B;
#endif
}
#endif
