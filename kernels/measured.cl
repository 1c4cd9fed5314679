// SPDX-License-Identifier: Apache-2.0
// The OpenCL entry of measured materials. One work-item owns KILN_LANES neighbouring places.
// KILN_MEASURED selects it among the entries: 1 values of f_r, 2 albedos.
//   nodes, curves  see measured.h
//   places         theta, cosine and sine of the light; for values x, y, z of the view: a stride each
//   points         see measured_albedo.h
//   batches        first point, point count: batch_count pairs
//   values         R, G, B, origin | [batch] R, G, B, extrapolated: a stride each

#ifdef KILN_MEASURED
__kernel void measured_table(__global const scalar* nodes, __global const scalar* curves,
                             const uint lobes, const uint rings, const uint spokes,
                             const uint reciprocal_beyond, const uint symmetric,
                             __global const scalar* places, __global const scalar* points,
                             __global const uint* batches, const uint batch_count,
                             const uint stride, __global scalar* values) {
    const size_t group = get_global_id(0);
    const size_t lane_groups = stride / KILN_LANES;
    const Measured m = {nodes, curves, lobes, rings, spokes, reciprocal_beyond, symmetric};
    __global const real* place = (__global const real*)places + group;
    __global real* out = (__global real*)values + group;
#if KILN_MEASURED == 1
    const MeasuredPair at = {place[0],               place[lane_groups],     place[2 * lane_groups],
                             place[3 * lane_groups], place[4 * lane_groups], place[5 * lane_groups]};
    const MeasuredValue value = measured_value(m, at);
    for (int k = 0; k < 3; ++k) out[k * lane_groups] = value.f[k];
    out[3 * lane_groups] = value.origin;
#else
    for (uint b = 0; b < batch_count; ++b) {
        const MeasuredAlbedo sum = measured_albedo(
            m, place[0], place[lane_groups], place[2 * lane_groups],
            points + (size_t)KILN_ALBEDO_SCALARS * batches[2 * b], batches[2 * b + 1]);
        for (int k = 0; k < 3; ++k) out[k * lane_groups] = sum.albedo[k];
        out[3 * lane_groups] = sum.extrapolated;
        out += 4 * lane_groups;
    }
#endif
}
#endif
