// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <compare>
#include <cstddef>
#include <span>

#include "server/compute/native_group.h"
#include "server/spec/job_spec.h"

namespace kiln {

/// What is asked of a measured material, by the numbers of kernels/measured.cl.
enum class MeasuredOperation { values = 1, albedos = 2 };

/// What a kernel of measured materials is specialised on: a closed set.
struct MeasuredKind {
    MeasuredOperation operation = MeasuredOperation::values;
    Precision precision = Precision::float32;
    auto operator<=>(const MeasuredKind&) const = default;
};

/// Lengths of curves of kernels/measured.h: a degree an entry.
inline constexpr std::size_t kMeasuredCurve = 92, kMeasuredEdges = 361;
constexpr std::size_t measured_curve_scalars(std::size_t lobes) {
    return 2 + 2 * kMeasuredCurve + lobes * (3 + kMeasuredEdges);
}
/// Nodes that a float can count.
inline constexpr std::size_t kMeasuredNodesMax = std::size_t{1} << 24;

/// One device call: kernels/measured.h at some places, or albedos at some theta_in.
template <typename Scalar>
struct MeasuredLaunch {
    MeasuredKind what;
    MeasuredShape shape;
    std::span<const Scalar> nodes;   ///< [lobe][ring][spoke][4]
    std::span<const Scalar> curves;  ///< measured_curve_scalars(lobes)
    std::size_t stride = 0;          ///< places padded to kLanesMax
    /// theta (radians), cosine, sine of the light; for values x, y, z of the view: a stride each
    std::span<const Scalar> places;
    std::span<const Scalar> points;       ///< albedos: four a point, kernels/measured_albedo.h
    std::span<const BatchRange> batches;  ///< albedos
    std::span<Scalar> values;             ///< out: R, G, B, origin | [batch] R, G, B, extrapolated
};

}  // namespace kiln
