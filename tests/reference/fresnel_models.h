// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <complex>
#include <functional>
#include <vector>

/// Fresnel reflectances as functions of the cosine between a direction and the microfacet normal,
/// in textbook complex numbers: nothing is arranged against cancellation. Relative error some
/// 1e-13 where |index - 1| > 1e-2, then 1e-15 / |index - 1|.
namespace kiln::reference {

/// A reflectance and the cosines in (0, 1) where it is not smooth, for quadrature to split at.
struct Fresnel {
    std::function<double(double cosine)> at;
    std::vector<double> kinks;
};

/// F = 1.
Fresnel fresnel_none();

/// F0 + (F90 - F0) (1 - c)^exponent, Schlick 1994, eq. 15 (there F90 = 1, exponent 5).
Fresnel fresnel_schlick(double f0, double f90 = 1, double exponent = 5);

/// Unpolarised reflectance of a smooth interface, Born and Wolf, Principles of Optics, section
/// 1.5.2. ior = n_t / n_i > 0; below 1 the light is inside the denser medium and is
/// reflected totally below the cosine sqrt(1 - ior^2), the only kink.
Fresnel fresnel_dielectric(double ior);

/// The same at a complex index eta + i k (Born and Wolf, section 14.2), from vacuum.
Fresnel fresnel_conductor(double eta, double k);

/// The index eta + i k whose conductor has this reflectance at normal view and this tint toward
/// the edge. Gulbrandsen 2014, "Artist Friendly Metallic Fresnel", its n(r, g) and k(r, n).
/// Both in [0, 1]; reflectivity above 0.99 is refused by std::domain_error rather than clamped.
std::complex<double> index_of_edge_tint(double reflectivity, double edge_tint);
Fresnel fresnel_edge_tint(double reflectivity, double edge_tint);

/// Schlick's curve bent at c = 1/7 (82 degrees): F = Schlick - b c (1 - c)^6 with b such that
/// F(1/7) = f82 * Schlick(1/7). Hoffman 2019, "Fresnel Equations Considered Harmful", with
/// f82 a tint relative to Schlick's curve as in MaterialX and OpenPBR (1 is Schlick), F90 = 1.
Fresnel fresnel_f82_tint(double f0, double f82);

/// F_avg = 2 * integral of F(c) c dc, by quadrature split at the kinks. Absolute error <= 1e-12.
double fresnel_average(const Fresnel& fresnel);

}  // namespace kiln::reference
