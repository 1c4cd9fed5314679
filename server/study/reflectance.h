// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <vector>

#include "server/spec/job_spec.h"

namespace kiln {

/// Two directions above the horizon: NoV and NoL in (0, 1], and the cosine of the azimuth between.
struct Directions {
    double NoV = 1, NoL = 1, cos_phi = 1;
    Directions swapped() const { return {NoL, NoV, cos_phi}; }
};

/// What terms of multiple scattering and couplings know of a material at one roughness: albedos at
/// the centres of as many equal steps of NoV as there are entries.
struct Albedos {
    std::vector<double> deficit;      ///< 1 − E
    std::vector<double> compensated;  ///< of one colour: the specular lobe with its compensation
    double average_deficit = 0;       ///< 1 − E_avg
};

/// f(V, L) of the whole material of a job in one colour, 1/sr, as its total_albedo integrates it:
/// the kernels' own functions in double. roughness in (0, 1]; at 0 a lobe is no function.
/// Positive but where a model is negative itself; never clamped. What light walks over facets
/// (ggx_lambert) is not in it: FacetWalks knows it, and walked_share() is its weight.
class Reflectance {
  public:
    Reflectance(const JobSpec& job, int colour, double roughness, const Albedos& albedos);
    double operator()(const Directions& d) const;
    double walked_share(const Directions& d) const;
    double albedo() const { return albedo_; }

  private:
    double specular(const Directions& d) const;
    double compensation(const Directions& d, double single) const;
    double diffuse(const Directions& d, double VoH) const;
    double kelemen(const Directions& d) const;
    double F(double cosine) const;

    const JobSpec& job_;
    const Albedos& albedos_;
    int colour_;
    double roughness_, albedo_ = 1, F_avg_ = 1, F_normal_ = 1, compensated_average_ = 0;
};

}  // namespace kiln
