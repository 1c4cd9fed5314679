// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <compare>
#include <cstddef>
#include <span>

#include "server/compute/fresnel.h"
#include "server/spec/job_spec.h"

namespace kiln {

/// KILN_FRESNEL_NONE, _SCHLICK (here the weight of F90, which takes no parameters) and
/// _SCHLICK_POWER.
inline constexpr int kNoFresnel = 0, kSchlickWeight = 1, kSchlickPower = 2;

/// In place of a diffuse lobe's number: the specular lobe, GGX, is integrated.
inline constexpr int kSpecular = -1;

/// What a quadrature kernel is specialised on: a closed set.
struct QuadratureKind {
    Masking masking = Masking::smith_correlated;
    /// The Fresnel term whose albedo B is, by its KILN_FRESNEL_ number, or kNoFresnel: no azimuth
    /// is integrated then. Of a diffuse lobe: what it is under, as 1 − F.
    int fresnel = kNoFresnel;
    Precision precision = Precision::float32;
    int diffuse = kSpecular;  ///< KILN_DIFFUSE_ number; no masking is read then
    auto operator<=>(const QuadratureKind&) const = default;
};

/// Planes of values: E, deficit (1 − E), and B where it is asked for; of a diffuse lobe the albedo.
constexpr std::size_t quadrature_planes(const QuadratureKind& kind) {
    if (kind.diffuse != kSpecular) return 1;
    return kind.fresnel != kNoFresnel ? 3 : 2;
}

/// Of the Fresnel term, and the diffuse albedo last.
inline constexpr std::size_t kQuadratureParameters = kFresnelParameters + 1;
using QuadratureParameters = std::array<double, kQuadratureParameters>;

/// Nodes of the longest pieces of the elevation (even), and of the azimuth (a right angle of it,
/// of a diffuse lobe).
struct QuadratureOrder {
    unsigned elevation = 0, azimuth = 0;
};

/// One device call: kernels/quadrature.h or quadrature_diffuse.h at one order.
template <typename Scalar>
struct QuadratureLaunch {
    QuadratureKind what;
    std::size_t texel_stride = 0;        ///< texels padded to kLanesMax
    std::span<const Scalar> texels;      ///< NoV of each, then alpha of each: 2 × texel_stride
    std::span<const Scalar> nodes;       ///< quadrature_nodes(what, order)
    std::span<const Scalar> parameters;  ///< kQuadratureParameters
    QuadratureOrder order;
    std::span<Scalar> values;  ///< out: [plane][texel_stride]
};

}  // namespace kiln
