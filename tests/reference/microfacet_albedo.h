// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "tests/reference/fresnel_models.h"
#include "tests/reference/microfacet_models.h"

/// Albedos of every microfacet lobe by one generic two-dimensional quadrature. No closed azimuth,
/// no distribution's own trick: what reference.h computes for ggx by other means must come out.
///
/// NoV in [1e-6, 1], alpha in [1e-3, 1], else std::domain_error; also where no two orders agree.
/// Absolute error <= 1e-9 for NoV, alpha >= 0.02 (times the size of F).
namespace kiln::reference {

/// E, the integral of F(VoH) D V NoL over the hemisphere of L, as an integral over half-vectors,
/// split at the horizon and at every kink of F and V.
double microfacet_albedo(const Microfacet& lobe, double NoV,
                         const Fresnel& fresnel = fresnel_none());

/// The same integral over elevation and azimuth of L: a second opinion that shares only D, V and F
/// with the first. `fresnel` must have no kinks. Absolute error <= 1e-8 for alpha >= 0.1.
double microfacet_albedo_over_light(const Microfacet& lobe, double NoV,
                                    const Fresnel& fresnel = fresnel_none());

/// 2 * integral of E NoV dNoV. Absolute error <= 1e-8. Takes 0.1 to 1 s.
double microfacet_average(const Microfacet& lobe, const Fresnel& fresnel = fresnel_none());

/// A and B of Schlick's Fresnel with this exponent: albedo(f0, f90) = f0 scale + f90 bias.
struct GeneralSplitSum {
    double scale;
    double bias;
};
GeneralSplitSum microfacet_split_sum(const Microfacet& lobe, double NoV, double exponent = 5);

}  // namespace kiln::reference
