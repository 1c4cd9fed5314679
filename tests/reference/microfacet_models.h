// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <vector>

/// Point functions of the isotropic microfacet lobe f = F D V, in the spelling of their papers.
/// Cosines are to the normal and in (0, 1]; alpha is the width in (0, 1]. Plain double arithmetic:
/// relative error some 1e-14, except where a docstring says otherwise.
namespace kiln::reference {

enum class Distribution {
    ggx,       ///< Walter, Marschner, Li, Torrance 2007, eq. 33
    beckmann,  ///< Walter et al. 2007, eq. 25
    charlie,   ///< Estevez and Kulla 2017, section on the distribution; alpha is the paper's r
};

enum class Visibility {
    smith_correlated,  ///< G2 = 1 / (1 + Lo + Li), Heitz 2014, eq. 99; ggx and beckmann
    smith_separable,   ///< G2 = 1 / ((1 + Lo) (1 + Li)), Heitz 2014, eq. 98; ggx and beckmann
    karis_ibl,         ///< G1 = c / (c (1 - k) + k), k = alpha / 2, Karis 2013, specular G
    karis_direct,      ///< the same with k = (r + 1)^2 / 8, r = sqrt(alpha), Karis 2013
    unreal_joint,      ///< V = 0.5 / (NoL (NoV (1 - a) + a) + NoV (NoL (1 - a) + a)), Unreal 4
    neubelt,           ///< V = 1 / (4 (NoL + NoV - NoL NoV)), Neubelt and Pettineo 2013
    charlie,           ///< G2 = 1 / (1 + Lo + Li), L of Estevez and Kulla 2017; charlie
    charlie_softened,  ///< ibid., L of the light raised to 1 + 2 (1 - NoL)^8: not reciprocal
};

struct Microfacet {
    Distribution distribution;
    Visibility visibility;
    double alpha;
};

/// Throws std::domain_error for alpha outside (0, 1] and for pairs without a meaning: Smith's
/// terms need a Lambda of the distribution, and the charlie terms are fitted to charlie alone.
void check_lobe(const Microfacet& lobe);

/// D in 1/sr at tan(theta_h) = tangent >= 0.
double distribution(Distribution kind, double alpha, double tangent);

/// Smith's Lambda at a cosine: ggx Heitz 2014, eq. 72; beckmann ibid., eq. 66 (with erf; absolute
/// error 1e-16). charlie throws std::domain_error.
double smith_lambda(Distribution kind, double alpha, double cosine);

/// The fitted Lambda of Estevez and Kulla 2017 (five constants at either end of alpha): a curve in
/// the cosine whose second derivative jumps at 1/2 and whose slope is infinite at 0 and at 1.
double charlie_lambda(double alpha, double cosine);

/// V = G2 / (4 NoL NoV) in 1/sr; the lobe with F = 1 is D V.
double visibility(const Microfacet& lobe, double NoV, double NoL);

/// The cosines in (0, 1] where visibility() is not analytic, for quadrature to split at.
std::vector<double> visibility_kinks(Visibility kind);

}  // namespace kiln::reference
