// SPDX-License-Identifier: Apache-2.0
#pragma once
// Plain types alone: the files compiled for one instruction set include this and nothing else.

namespace kiln {

/// A run of points that is summed in working precision.
struct BatchRange {
    unsigned first_point = 0;
    unsigned point_count = 0;
};

/// One lane group of a launch, see Launch in backend.h; pointers already stand at the group.
template <typename Scalar>
struct NativeGroup {
    const Scalar* NoV;
    const Scalar* alpha;
    const Scalar* points;
    const BatchRange* batches;
    unsigned batch_count;
    unsigned long texel_stride;
    Scalar* sums;
};

template <typename Scalar>
using NativeFunction = void (*)(const NativeGroup<Scalar>&);

/// One lane group of a QuadratureLaunch, see quadrature_launch.h; pointers already stand at the
/// group.
template <typename Scalar>
struct NativeQuadratureGroup {
    const Scalar* NoV;
    const Scalar* alpha;
    const Scalar* nodes;
    unsigned order;
    unsigned long texel_stride;
    Scalar* values;
};

template <typename Scalar>
using NativeQuadrature = void (*)(const NativeQuadratureGroup<Scalar>&);

/// The functions of one instruction set. Arguments as Specialisation, by number.
struct NativeKernels {
    int float_lanes, double_lanes;
    NativeFunction<float> (*find_float)(int masking, int importance, int terms, int averaged);
    NativeFunction<double> (*find_double)(int masking, int importance, int terms, int averaged);
    NativeQuadrature<float> (*find_quadrature_float)(int masking, int fresnel);
    NativeQuadrature<double> (*find_quadrature_double)(int masking, int fresnel);
};

extern const NativeKernels kNativeV2, kNativeV3, kNativeV4;

}  // namespace kiln
