// SPDX-License-Identifier: Apache-2.0
// Measured materials for one instruction set and one precision: included by native_isa.cpp behind
// native_kernels.h, into the same namespace.

static real loaded(const scalar* from) {
    real value;
    for (int lane = 0; lane < KILN_LANES; ++lane) value[lane] = from[lane];
    return value;
}

static Measured measured_of(const NativeMeasuredGroup<scalar>& group) {
    return {group.nodes,          group.curves,       group.shape.lobes,
            group.shape.rings,    group.shape.spokes, group.shape.reciprocal_beyond,
            group.shape.symmetric};
}

static void measured_values(const NativeMeasuredGroup<scalar>& group) {
    const auto place = [&](int plane) { return loaded(group.places + plane * group.stride); };
    const MeasuredPair at = {place(0), place(1), place(2), place(3), place(4), place(5)};
    const MeasuredValue value = measured_value(measured_of(group), at);
    for (int k = 0; k < 3; ++k) store(group.values + k * group.stride, value.f[k]);
    store(group.values + 3 * group.stride, value.origin);
}

static void measured_albedos(const NativeMeasuredGroup<scalar>& group) {
    const auto place = [&](int plane) { return loaded(group.places + plane * group.stride); };
    scalar* out = group.values;
    for (unsigned b = 0; b < group.batch_count; ++b) {
        const BatchRange batch = group.batches[b];
        const MeasuredAlbedo sum =
            measured_albedo(measured_of(group), place(0), place(1), place(2),
                            group.points + (unsigned long)KILN_ALBEDO_SCALARS * batch.first_point,
                            batch.point_count);
        for (int k = 0; k < 3; ++k) store(out + k * group.stride, sum.albedo[k]);
        store(out + 3 * group.stride, sum.extrapolated);
        out += 4 * group.stride;
    }
}
