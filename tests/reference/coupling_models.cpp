// SPDX-License-Identifier: Apache-2.0
#include "tests/reference/coupling_models.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <utility>

#include "tests/reference/cosine_average.h"

namespace kiln::reference {
namespace {

// Below this cosine an albedo is not asked for; the light from there weighs its square.
constexpr double kLowest = 1e-5;

double compensated(const Specular& s, double albedo, double white, double factor) {
    switch (s.multiscatter) {
        case Multiscatter::none:
            return albedo;
        case Multiscatter::kulla_conty:
        case Multiscatter::kulla_conty_first_power:
            return albedo + factor * (1 - white);
        case Multiscatter::turquin:
            return albedo * (1 + s.fresnel.at(1) * (1 - white) / white);
    }
    throw std::domain_error("reference: unknown multiple scattering");
}

}  // namespace

double kulla_conty_factor(double E_avg, double F_avg, int power) {
    return std::pow(F_avg, power) * E_avg / (1 - F_avg * (1 - E_avg));
}

SpecularAlbedo::SpecularAlbedo(Specular specular) : specular_(std::move(specular)) {
    const bool first = specular_.multiscatter == Multiscatter::kulla_conty_first_power;
    if (first || specular_.multiscatter == Multiscatter::kulla_conty) {
        const double E_avg = microfacet_average(specular_.lobe);
        factor_ = kulla_conty_factor(E_avg, fresnel_average(specular_.fresnel), first ? 1 : 2);
        white_factor_ = kulla_conty_factor(E_avg, 1, 2);
    }
}

double SpecularAlbedo::at(double NoV) const {
    const double albedo = microfacet_albedo(specular_.lobe, NoV, specular_.fresnel);
    if (specular_.multiscatter == Multiscatter::none) return albedo;
    return compensated(specular_, albedo, microfacet_albedo(specular_.lobe, NoV), factor_);
}

double SpecularAlbedo::white(double NoV) const {
    const Specular one{specular_.lobe, fresnel_none(), specular_.multiscatter};
    const double albedo = microfacet_albedo(specular_.lobe, NoV);
    return compensated(one, albedo, albedo, white_factor_);
}

double SpecularAlbedo::average() const {
    std::vector<double> kinks = visibility_kinks(specular_.lobe.visibility);
    return cosine_average([this](double mu) { return at(mu); }, kinks, kLowest);
}

Material::Material(Coupling coupling, Specular specular, Diffuse diffuse)
    : coupling_(coupling), specular_(std::move(specular)), diffuse_(diffuse) {
    if (coupling_ == Coupling::kelemen && diffuse_.model != DiffuseModel::lambert)
        average_ = specular_.average();
}

double Material::total(double NoV) const {
    const Fresnel& fresnel = specular_.model().fresnel;
    switch (coupling_) {
        case Coupling::none:
            return diffuse_albedo(diffuse_, NoV) + specular_.at(NoV);
        case Coupling::half_vector: {
            const DiffuseWeight transmitted{
                [&](double, double VoH) { return 1 - fresnel.at(VoH); }, fresnel.kinks, {}};
            return diffuse_integral(diffuse_, NoV, transmitted) + specular_.at(NoV);
        }
        case Coupling::view: {
            const double F = fresnel.at(NoV);
            return (1 - F) * diffuse_albedo(diffuse_, NoV) + F * specular_.white(NoV);
        }
        case Coupling::kelemen:
            return kelemen(NoV);
    }
    throw std::domain_error("reference: unknown coupling");
}

double Material::kelemen(double NoV) const {
    const double above = specular_.at(NoV);
    if (diffuse_.model == DiffuseModel::lambert) return above + diffuse_.albedo * (1 - above);
    // A lobe that reflects all leaves nothing to the diffuse one: (1 - E)^2 over (1 - E_avg) is 0.
    if (1 - average_ < 1e-9) return above;
    std::map<double, double> passed;  // every azimuth of a ring asks for the same
    const DiffuseWeight transmitted{[&](double NoL, double) {
                                        const auto found = passed.try_emplace(NoL, 0);
                                        if (found.second)
                                            found.first->second =
                                                1 - specular_.at(std::clamp(NoL, kLowest, 1.0));
                                        return found.first->second;
                                    },
                                    {},
                                    visibility_kinks(specular_.model().lobe.visibility)};
    return above + (1 - above) / (1 - average_) * diffuse_integral(diffuse_, NoV, transmitted);
}

}  // namespace kiln::reference
