// SPDX-License-Identifier: Apache-2.0
#include "server/study/reflectance.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "server/compute/axes.h"
#include "server/compute/fresnel.h"
#include "server/compute/one_lane.h"
#include "server/compute/plan.h"

namespace kiln {

namespace {

double sine(double cosine) { return std::sqrt((1 - cosine) * (1 + cosine)); }

/// Linear between the centres of equal steps, as far as they go.
double at(const std::vector<double>& values, double NoV) {
    const auto count = static_cast<double>(values.size());
    const double x = std::clamp(NoV * count - 0.5, 0.0, count - 1);
    const auto below = static_cast<std::size_t>(x);
    const std::size_t above = std::min(below + 1, values.size() - 1);
    return values[below] + (x - static_cast<double>(below)) * (values[above] - values[below]);
}

}  // namespace

Reflectance::Reflectance(const JobSpec& job, int colour, double roughness, const Albedos& albedos)
    : job_(job), albedos_(albedos), colour_(colour), roughness_(roughness) {
    const auto& albedo = job.diffuse.albedo;
    albedo_ = albedo[albedo.size() == 3 ? static_cast<std::size_t>(colour) : 0];
    F_normal_ = F(1);
    if (job.multiscatter != Multiscatter::none) F_avg_ = fresnel_average(job.fresnel, colour);
    const auto count = static_cast<double>(albedos.compensated.size());
    for (std::size_t i = 0; i < albedos.compensated.size(); ++i)
        compensated_average_ +=
            2 * albedos.compensated[i] * (static_cast<double>(i) + 0.5) / (count * count);
}

double Reflectance::F(double cosine) const { return fresnel(job_.fresnel, colour_, cosine); }

double Reflectance::operator()(const Directions& d) const {
    const double VoH = one_lane::diffuse_directions(d.NoV, d.NoL, sine(d.NoL), d.cos_phi).VoH;
    const double single = specular(d);
    // Of `view`, F stands outside of the lobe.
    const double factor = F(job_.coupling == Coupling::view ? d.NoV : VoH);
    return factor * single + compensation(d, factor * single) + diffuse(d, VoH);
}

double Reflectance::specular(const Directions& d) const {
    const KernelMaterial lobe = lobe_of(job_);
    const double alpha = alpha_from_roughness(roughness_);
    const auto s =
        one_lane::scatter_hemisphere(KILN_IMPORTANCE_COSINE, d.NoV, d.cos_phi, d.NoL, sine(d.NoL));
    const double D = one_lane::microfacet_D(lobe.distribution, alpha, s.NoV, s.NoH, s.sin2_H);
    return one_lane::microfacet_product(lobe.distribution, lobe.masking, alpha, s, D);
}

double Reflectance::compensation(const Directions& d, double single) const {
    if (job_.multiscatter == Multiscatter::none) return 0;
    const double view = at(albedos_.deficit, d.NoV);
    if (job_.multiscatter == Multiscatter::turquin) return single * F_normal_ * view / (1 - view);
    const double missing = albedos_.average_deficit;
    const double power = job_.multiscatter == Multiscatter::kulla_conty_linear ? 1 : F_avg_;
    const double F_ms = F_avg_ * power * (1 - missing) / (1 - F_avg_ * missing);
    return F_ms * view * at(albedos_.deficit, d.NoL) / (std::numbers::pi * missing);
}

double Reflectance::diffuse(const Directions& d, double VoH) const {
    if (job_.diffuse.model == DiffuseModel::none) return 0;
    if (job_.diffuse.model == DiffuseModel::ggx_lambert && job_.coupling != Coupling::kelemen)
        return 0;
    if (job_.coupling == Coupling::kelemen) return kelemen(d);
    const int model =
        static_cast<int>(job_.diffuse.model) - static_cast<int>(DiffuseModel::lambert);
    const auto directions = one_lane::diffuse_directions(d.NoV, d.NoL, sine(d.NoL), d.cos_phi);
    const double lobe =
        one_lane::diffuse_lobe(model, directions, roughness_, albedo_) / std::numbers::pi;
    switch (job_.coupling) {
        case Coupling::half_vector:
            return (1 - F(VoH)) * lobe;
        case Coupling::view:
            return (1 - F(d.NoV)) * lobe;
        default:
            return lobe;
    }
}

double Reflectance::walked_share(const Directions& d) const {
    return job_.coupling == Coupling::view ? 1 - F(d.NoV) : 1;
}

// Kulla, Conty 2017 after Kelemen, Szirmay-Kalos 2001: what the specular lobe leaves over on both
// sides, normalised.
double Reflectance::kelemen(const Directions& d) const {
    return albedo_ * (1 - at(albedos_.compensated, d.NoV)) * (1 - at(albedos_.compensated, d.NoL)) /
           (std::numbers::pi * (1 - compensated_average_));
}

}  // namespace kiln
