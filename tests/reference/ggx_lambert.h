// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <random>
#include <vector>

#include "tests/reference/reference.h"

/// A surface of GGX microfacets that each reflect as Lambert: the first bounce by quadrature, every
/// bounce by invariance, all of them by walking on Smith's microsurface. Heitz, Hanika, d'Eon,
/// Dachsbacher 2016, "Multiple-Scattering Microfacet BSDFs with the Smith Model", and Heitz and
/// Dupuy 2015, "Implementing a Simple Anisotropic Rough Diffuse Material with Stochastic
/// Evaluation".
///
/// NoV in [1e-4, 1], alpha in [1e-3, 1] (GGX width), else std::domain_error. All values at rho = 1
/// unless said: the first bounce is proportional to rho, bounce number k to rho^k.
namespace kiln::reference {

/// One bounce: f = 1 / (pi NoV NoL) * integral of <V,m> <L,m> G2(V, L) D(m) dm, Heitz and Dupuy
/// 2015. cos_delta_phi in [-1, 1]. Relative error <= 1e-6.
double ggx_lambert_single(double alpha, double NoV, double NoL, double cos_delta_phi,
                          Masking masking = Masking::correlated);

/// Its albedo: the azimuths of V and of L around m separate and are in closed form, leaving L's
/// elevation and m's. Absolute error <= 1e-9.
double ggx_lambert_single_albedo(double alpha, double NoV, Masking masking = Masking::correlated);

/// 2 * integral of that NoV dNoV. Absolute error <= 1e-8. Some 0.2 s.
double ggx_lambert_single_average(double alpha, Masking masking = Masking::correlated);

/// The share of the light that leaves after 1, 2 … `bounces` facets, for each NoV: the albedo is
/// the sum of rho^bounce times these, whatever rho. By Ambartsumian's invariance: in tau = -ln C1
/// of the height the microsurface is a homogeneous half-space, so that another thin layer on top
/// changes nothing, which gives each order from those before it. Directions are `ordinates`
/// Gauss-Legendre elevations; with 40, absolute error <= 1e-8 for alpha >= .1 and NoV >= .1, 1e-7
/// at NoV = .01. Some 0.2 s.
std::vector<std::vector<double>> ggx_lambert_shares(double alpha, const std::vector<double>& NoV,
                                                    int bounces, int ordinates = 40);

/// The albedo from them.
double ggx_lambert_albedo(const std::vector<double>& shares, double rho);

/// The same of cosine-distributed views: 2 * integral of the shares NoV dNoV.
std::vector<double> ggx_lambert_average_shares(double alpha, int bounces, int ordinates = 40);

/// Where a light path from V leaves the surface again, and after how many bounces (>= 1).
struct Walk {
    int bounces;
    double NoL;
};

/// One path (height-correlated masking by construction). Normals by rejection in the stretched
/// frame, heights as their cumulative distribution C1, which is all that a walk depends on.
/// Throws std::runtime_error after 10^5 bounces.
Walk ggx_lambert_walk(double alpha, double NoV, std::mt19937_64& random);

/// A Monte Carlo mean and the standard deviation of that mean.
struct Estimate {
    double mean;
    double standard_error;
};

/// Albedos of `walks` independent paths: every bounce, and the first one alone.
struct WalkedAlbedo {
    Estimate all;     ///< E[rho^bounces]; exactly 1 at rho = 1
    Estimate single;  ///< rho times the share of one bounce
};
WalkedAlbedo ggx_lambert_walked_albedo(double alpha, double NoV, double rho, int walks,
                                       std::uint64_t seed);

/// The same over cosine-distributed V: the average albedo.
WalkedAlbedo ggx_lambert_walked_average(double alpha, double rho, int walks, std::uint64_t seed);

}  // namespace kiln::reference
