// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <compare>
#include <cstddef>
#include <span>

#include "server/spec/job_spec.h"

namespace kiln {

/// What a quadrature kernel is specialised on: a closed set.
struct QuadratureKind {
    Masking masking = Masking::smith_correlated;
    bool fresnel = false;  ///< B too: the azimuth is integrated as well
    Precision precision = Precision::float32;
    auto operator<=>(const QuadratureKind&) const = default;
};

/// Planes of values: E, deficit (1 − E), and B where it is asked for.
constexpr std::size_t quadrature_planes(const QuadratureKind& kind) { return kind.fresnel ? 3 : 2; }

/// One device call: kernels/quadrature.h at one order.
template <typename Scalar>
struct QuadratureLaunch {
    QuadratureKind what;
    std::size_t texel_stride = 0;    ///< texels padded to kLanesMax
    std::span<const Scalar> texels;  ///< NoV of each, then alpha of each: 2 × texel_stride
    std::span<const Scalar> nodes;   ///< quadrature_nodes(order)
    unsigned order = 0;
    std::span<Scalar> values;  ///< out: [plane][texel_stride]
};

}  // namespace kiln
