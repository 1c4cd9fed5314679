// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <optional>

#include "server/spec/fresnel_spec.h"

namespace kiln {

/// What the kernels evaluate without overflow or loss in float. f0, f90, f82 and edge_tint lie in
/// [0, 1].
struct FresnelLimits {
    static constexpr double exponent_max = 1000;  ///< and above 0
    static constexpr double ior_min = 1e-4, ior_max = 1e6;
    /// eta and k >= 0 each, the larger of a pair within these.
    static constexpr double index_min = 1e-4, index_max = 1e6;
    /// And at least 0. At 1 no finite pair exists: a perfect mirror is the model `none`.
    static constexpr double reflectivity_max = 0.99999;
};

/// Slots a channel, = KILN_FRESNEL_PARAMETERS.
inline constexpr int kFresnelParameters = 8;

/// Which function of kernels/fresnel.h evaluates the model: its KILN_FRESNEL_ number.
int fresnel_function(const FresnelModel& model);

/// The scalars that it takes for `channel` (0 … 2; a single value serves every channel), unused
/// slots 0. Throws Error "fresnel_range" where a parameter is outside FresnelLimits, not finite or
/// missing.
std::array<double, kFresnelParameters> fresnel_parameters(const FresnelModel& model, int channel);

/// F(VoH), VoH in [0, 1]: the kernel's function, in double. Throws as above.
double fresnel(const FresnelModel& model, int channel, double VoH);

/// F_avg = 2 ∫ F(μ) μ dμ over [0, 1], within 1e-12: in closed form, but for conductors. Throws as
/// above.
double fresnel_average(const FresnelModel& model, int channel);

/// A complex index of refraction, eta + i k.
struct IndexPair {
    double eta, k;
};

/// Gulbrandsen 2014: the pair that reflects `reflectivity` at normal incidence, with eta largest at
/// edge_tint 0 (k = 0: darkest towards the edge) and least at 1. Both in the range of
/// FresnelLimits.
IndexPair index_from_edge_tint(double reflectivity, double edge_tint);

/// The least f82 at which the F82 tint of this f0 is nowhere negative. Below it the formula is, by
/// at most 0.13, somewhat above VoH = 1/7; nothing clamps that.
double f82_least(double f0);

/// Where the reflectance of a channel leaves [0, 1].
struct Excursion {
    double least = 0;           ///< the lowest value, below 0
    double at = 0;              ///< the VoH where it is
    double begin = 0, end = 0;  ///< the VoH between which it is negative, to 1e-3
};
/// Only f82_tint has one, below f82_least().
std::optional<Excursion> fresnel_excursion(const FresnelModel& model, int channel);

}  // namespace kiln
