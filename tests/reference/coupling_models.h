// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "tests/reference/diffuse_models.h"
#include "tests/reference/microfacet_albedo.h"

/// Specular lobes with what multiple scattering gives back, and materials of a diffuse and a
/// specular lobe: their value in a white furnace, the integral of f NoL over all L.
namespace kiln::reference {

enum class Multiscatter {
    none,
    kulla_conty,              ///< F_ms = F_avg^2 E_avg / (1 - F_avg (1 - E_avg))
    kulla_conty_first_power,  ///< F_ms = F_avg E_avg / (1 - F_avg (1 - E_avg))
    turquin,                  ///< the lobe times 1 + F_ss (1 - E) / E, F_ss = F(1)
};

enum class Coupling {
    none,         ///< f_d + F(VoH) f_s
    half_vector,  ///< (1 - F(VoH)) f_d + F(VoH) f_s
    view,         ///< (1 - F(NoV)) f_d + F(NoV) f_s
    kelemen,      ///< (1 - E_s(V)) (1 - E_s(L)) / (1 - E_s,avg) f_d + F(VoH) f_s
};

/// Share of the energy that single scattering misses which Kulla and Conty 2017 give back.
/// power 2 sums the series of bounces F_avg^(k+1) (1 - E_avg)^(k-1) E_avg over k >= 1; power 1 is
/// what their slides and several programs use.
double kulla_conty_factor(double E_avg, double F_avg, int power);

struct Specular {
    Microfacet lobe;
    Fresnel fresnel;
    Multiscatter multiscatter = Multiscatter::none;
};

/// A specular lobe whose averages (what its multiple scattering needs of them) are computed once,
/// 0.1 to 1 s.
class SpecularAlbedo {
  public:
    explicit SpecularAlbedo(Specular specular);

    /// Integral of F f_s NoL, compensated: E_F + F_ms (1 - E) (Kulla and Conty 2017), or
    /// E_F (1 + F(1) (1 - E) / E) (Turquin 2019, eq. 16). Absolute error <= 1e-8.
    double at(double NoV) const;

    /// The same with F = 1 throughout: at most 1 for a lobe that Smith masks.
    double white(double NoV) const;

    /// 2 * integral of at(NoV) NoV dNoV. Absolute error <= 1e-7.
    double average() const;

    const Specular& model() const { return specular_; }

  private:
    Specular specular_;
    double factor_ = 0;  ///< F_ms
    double white_factor_ = 0;
};

/// A diffuse under a specular lobe.
class Material {
  public:
    Material(Coupling coupling, Specular specular, Diffuse diffuse);

    /// White-furnace value at NoV in [1e-5, 1]. Absolute error <= 1e-7.
    /// view: F(NoV) stands before white(NoV), so that multiple scattering keeps the blend between
    /// two lobes of which neither exceeds 1.
    /// kelemen: E_s is the compensated albedo; Kelemen and Szirmay-Kalos 2001 and Kulla and
    /// Conty 2017 write it for Lambert's f_d, where the value is E_s + rho (1 - E_s) by the
    /// normalisation alone. Another f_d takes a second or two.
    double total(double NoV) const;

  private:
    double kelemen(double NoV) const;

    Coupling coupling_;
    SpecularAlbedo specular_;
    Diffuse diffuse_;
    double average_ = 0;  ///< of specular_, where the coupling asks for it
};

}  // namespace kiln::reference
