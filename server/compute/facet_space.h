// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <span>
#include <vector>

namespace kiln {

/// ggx_lambert without chance: the albedo of Lambertian GGX microfacets and of what they throw at
/// each other, where kernels/ggx_lambert.h walks. In τ = −ln C1 of the height the microsurface is a
/// homogeneous half-space (Heitz, Hanika, d'Eon, Dachsbacher 2016, section 4), whose reflectance R
/// another thin layer of it does not change (Ambartsumian 1943): a quadratic equation for R over
/// the directions of a rule, solved once for a roughness and an albedo. Facets that a ray from V
/// meets lie exponentially deep, at the rate 1 + Λ(V), and so do those that meet the light on its
/// way up: what gets out is the solution of linear equations for each V.
///
/// In double, by + − × ÷ √ alone: the same bits everywhere.
class FacetSpace {
  public:
    /// alpha in [0, 1]; `directions` of the rule, up and down alike, 2 at least.
    FacetSpace(double alpha, unsigned directions);

    /// The space with facets of one albedo in [0, 1].
    struct Lit {
        double rho = 0;
        std::vector<double> reflected;  ///< R dc: [down][up]
        std::vector<double> rising;     ///< [up][up]: where light that is met on its way up goes on
    };
    Lit lit(double rho) const;

    /// The directional albedo of each of `lights` at NoV in [0, 1].
    std::vector<double> albedo(double NoV, std::span<const Lit> lights) const;
    /// 2 ∫ of it NoV dNoV.
    double average(const Lit& light) const;

  private:
    struct Direction {
        double cosine, sine, weight;
    };
    /// Normals of one inclination, and their share of D.
    struct Ring {
        double cosine, sine, weight;
    };
    /// Light that facets send on, a direction of the rule at a time, up ones first; their sum is 1.
    using Turned = std::vector<double>;

    double lambda(const Direction& d) const;
    void append_rings(double begin, double end, std::vector<Ring>& rings) const;
    double edge_of(const Direction& d) const;
    /// Adds what normals of these rings turn a ray to, which comes down or from below.
    void turn(const Direction& from, bool above, std::span<const Ring> rings,
              std::span<const double> seen, Turned& to) const;
    void normalise(Turned& to) const;
    Turned first_turn(const Direction& view) const;
    std::vector<double> let_out(const Direction& view, const Lit& light) const;
    std::vector<double> seen_by_rule(std::span<const Ring> rings) const;

    double alpha_;
    std::vector<Direction> rule_;
    std::vector<double> rate_;                     ///< Λ of each
    std::vector<double> edges_;                    ///< of the pieces of the rings' variable
    std::vector<Ring> rings_;                      ///< kRingsAPiece of each piece
    std::vector<double> seen_;                     ///< [ring][direction] facing up, then down
    std::vector<Turned> from_above_, from_below_;  ///< of rays that come down, that come up
};

}  // namespace kiln
