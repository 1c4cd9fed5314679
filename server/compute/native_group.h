// SPDX-License-Identifier: Apache-2.0
#pragma once
// Plain types alone: the files compiled for one instruction set include this and nothing else.

namespace kiln {

/// A run of points that is summed in working precision.
struct BatchRange {
    unsigned first_point = 0;
    unsigned point_count = 0;
};

/// What a kernel computes, by the numbers of kernels/*.h. Mirrored by Integrand and Material there.
struct KernelMaterial {
    int distribution = 0, masking = 0, importance = 0;
    int terms = 0;     ///< bits 1 << term, see terms.h
    int averaged = 0;  ///< NoV comes with every point
    int fresnel = 0, diffuse = 0;
    int general = 0;  ///< by kernels/material.h, not by the fast path of kernels/batch.h
};

/// One lane group of a launch, see Launch in backend.h; pointers already stand at the group.
template <typename Scalar>
struct NativeGroup {
    const Scalar* NoV;
    const Scalar* alpha;
    const Scalar* points;
    const Scalar* parameters;
    const BatchRange* batches;
    unsigned batch_count;
    unsigned long texel_stride;
    KernelMaterial material;
    Scalar* sums;
};

template <typename Scalar>
using NativeFunction = void (*)(const NativeGroup<Scalar>&);

/// Which rule, and what it reads of its kind, by the numbers of kernels/*.h.
struct QuadratureNumbers {
    enum class Rule { smith, lobe, diffuse } rule = Rule::smith;
    int distribution = 0, masking = 0, fresnel = 0, total_reflection = 0, diffuse = 0;
};

/// One lane group of a QuadratureLaunch, see quadrature_launch.h; pointers already stand at the
/// group.
template <typename Scalar>
struct NativeQuadratureGroup {
    const Scalar* NoV;
    const Scalar* alpha;
    const Scalar* nodes;
    const Scalar* parameters;
    QuadratureNumbers what;
    unsigned order, azimuths;
    unsigned long texel_stride;
    Scalar* values;
};

template <typename Scalar>
using NativeQuadrature = void (*)(const NativeQuadratureGroup<Scalar>&);

/// Sizes and ways of a measured material's regular form, mirrored by Measured of
/// kernels/measured.h.
struct MeasuredShape {
    unsigned lobes = 0, rings = 0, spokes = 0;
    unsigned reciprocal_beyond = 0, symmetric = 0;
};

/// One lane group of a MeasuredLaunch, see measured_launch.h; pointers already stand at the group.
template <typename Scalar>
struct NativeMeasuredGroup {
    const Scalar* nodes;
    const Scalar* curves;
    MeasuredShape shape;
    const Scalar* places;
    const Scalar* points;
    const BatchRange* batches;
    unsigned batch_count;
    unsigned long stride;
    Scalar* values;
};

template <typename Scalar>
using NativeMeasured = void (*)(const NativeMeasuredGroup<Scalar>&);

/// The functions of one precision.
template <typename Scalar>
struct NativeFunctions {
    int lanes;
    NativeFunction<Scalar> (*find)(const KernelMaterial&);
    NativeQuadrature<Scalar> (*find_quadrature)(const QuadratureNumbers&);
    NativeMeasured<Scalar> measured_values, measured_albedos;
};

/// Those of one instruction set.
struct NativeKernels {
    NativeFunctions<float> in_float;
    NativeFunctions<double> in_double;
};

extern const NativeKernels kNativeV2, kNativeV3, kNativeV4;

}  // namespace kiln
