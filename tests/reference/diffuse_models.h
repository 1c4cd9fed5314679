// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <string_view>
#include <vector>

/// Diffuse lobes in the spelling of their papers, and their albedos by quadrature over (NoL, phi).
namespace kiln::reference {

/// What `roughness` means is the model's own affair and written beside it.
enum class DiffuseModel {
    lambert,            ///< none
    burley,             ///< perceptual r in [0, 1] (not alpha). Burley 2012, section 5.3
    burley_normalized,  ///< perceptual r. Lagarde and de Rousiers 2014, Frostbite's listing
    oren_nayar,         ///< sigma in radians, >= 0. Oren and Nayar 1994, eq. 30 ("qualitative")
    oren_nayar_full,  ///< sigma in radians. Oren and Nayar 1994, eq. 27 to 29, with interreflection
    fon,              ///< r in [0, 1], Fujii's. Portsmouth, Kutz and Hill 2025, eq. for f_FON
    eon,              ///< r in [0, 1]. Portsmouth, Kutz and Hill 2025, exact E_FON
    eon_unreal,       ///< R in [0, 1] as handed to Diffuse_EON of Unreal 5.7 (which hands it 0.4
                      ///< times the material's perceptual roughness). Not reciprocal
    chan2018,         ///< perceptual R in (0, 1], a2 = R^4. Chan 2018, with Unreal's clamp at 1
    chan2018_no_clamp,  ///< the same without Unreal's min(1, lobe)
    chan2024,           ///< perceptual R in [0, 1]. Chan 2024, as in Unreal 5.7
};

/// The model of a word of job documents. std::domain_error where there is none.
DiffuseModel diffuse_model(std::string_view word);

struct Diffuse {
    DiffuseModel model;
    double roughness = 0;
    double albedo = 1;  ///< rho in [0, 1]; the paper's parameter, not the resulting albedo
};

/// f in 1/sr at cosines to the normal in (0, 1] and the cosine of the azimuth between V and L.
/// Plain double arithmetic, relative error some 1e-13 for cosines >= 1e-5. The area light terms of
/// Unreal are at their value for a point light.
double diffuse_brdf(const Diffuse& lobe, double NoV, double NoL, double cos_delta_phi);

/// Something to multiply f with: a function of NoL and VoH that is smooth but at the VoH of `kinks`
/// and the NoL of `light_kinks`, all in (0, 1].
struct DiffuseWeight {
    std::function<double(double NoL, double VoH)> at;
    std::vector<double> kinks;
    std::vector<double> light_kinks;
};

/// Integral of f weight NoL over the hemisphere of L. NoV in [1e-5, 1], else std::domain_error.
/// Absolute error <= 1e-9 (times the size of the weight); chan2018 with its clamp 1e-7.
/// Split at NoL = NoV, at a right angle of azimuths, at the clamp of chan2018 and at the kinks.
double diffuse_integral(const Diffuse& lobe, double NoV, const DiffuseWeight& weight);

/// Integral of f NoL over the hemisphere; accuracy as above. May rightly exceed 1 (burley, both
/// oren_nayar, eon_unreal, chan2018).
double diffuse_albedo(const Diffuse& lobe, double NoV);

/// 2 * integral of the albedo NoV dNoV. Absolute error <= 1e-7. Some 0.1 s.
double diffuse_average(const Diffuse& lobe);

/// E of f_FON at rho = 1 (Portsmouth, Kutz and Hill 2025, exact form), with E = A_F at NoV = 1.
double fon_albedo(double roughness, double NoV);

}  // namespace kiln::reference
