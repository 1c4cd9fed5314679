// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <compare>
#include <cstddef>
#include <span>
#include <variant>

#include "server/compute/fresnel.h"
#include "server/spec/job_spec.h"

namespace kiln {

/// KILN_FRESNEL_NONE, _SCHLICK (here the weight of F90, which takes no parameters) and
/// _SCHLICK_POWER.
inline constexpr int kNoFresnel = 0, kSchlickWeight = 1, kSchlickPower = 2;

/// GGX under one of Smith's maskings: kernels/quadrature.h.
struct SmithRule {
    Masking masking = Masking::smith_correlated;
    /// The Fresnel term whose albedo B is, by its KILN_FRESNEL_ number, or kNoFresnel: no azimuth
    /// is integrated then.
    int fresnel = kNoFresnel;
    auto operator<=>(const SmithRule&) const = default;
};

/// Any microfacet lobe, by the numbers of kernels/microfacet.h: kernels/quadrature_lobe.h.
struct LobeRule {
    int distribution = 0, masking = 0;
    int fresnel = kNoFresnel;       ///< as of SmithRule
    bool total_reflection = false;  ///< a dielectric's with an ior below 1
    auto operator<=>(const LobeRule&) const = default;
};

/// A diffuse lobe by its KILN_DIFFUSE_ number, whole or as 1 - F of a Fresnel term lets it through:
/// kernels/quadrature_diffuse.h.
struct DiffuseRule {
    int diffuse = 0, fresnel = kNoFresnel;
    auto operator<=>(const DiffuseRule&) const = default;
};

/// What a quadrature kernel is specialised on: a closed set.
struct QuadratureKind {
    std::variant<SmithRule, LobeRule, DiffuseRule> rule;
    Precision precision = Precision::float32;
    auto operator<=>(const QuadratureKind&) const = default;
};

constexpr bool is_diffuse(const QuadratureKind& kind) {
    return std::holds_alternative<DiffuseRule>(kind.rule);
}
constexpr int fresnel_of(const QuadratureKind& kind) {
    return std::visit([](const auto& rule) { return rule.fresnel; }, kind.rule);
}

/// Planes of values: E, deficit (1 − E), and B where it is asked for; of a diffuse lobe the albedo.
constexpr std::size_t quadrature_planes(const QuadratureKind& kind) {
    if (is_diffuse(kind)) return 1;
    return fresnel_of(kind) != kNoFresnel ? 3 : 2;
}

/// Of the Fresnel term, and the diffuse albedo last.
inline constexpr std::size_t kQuadratureParameters = kFresnelParameters + 1;
using QuadratureParameters = std::array<double, kQuadratureParameters>;

/// Nodes of the longest pieces of the elevation (even), and of the azimuth (a right angle of it,
/// of a diffuse lobe).
struct QuadratureOrder {
    unsigned elevation = 0, azimuth = 0;
};

/// One device call: a rule at one order.
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
