// SPDX-License-Identifier: Apache-2.0
#include "server/image/model_words.h"

#include <array>
#include <cmath>
#include <span>

#include "server/image/describing.h"
#include "server/spec/channels.h"
#include "server/spec/metals.h"
#include "server/spec/words.h"

namespace kiln {
namespace {

using describing::any, describing::is_split_sum, describing::number, describing::text;

std::string numbers(std::span<const double> values) {
    std::string words;
    for (const double value : values) words += (words.empty() ? "" : " ") + number(value);
    return words;
}

bool along_z(const JobSpec& job, Parameter parameter) {
    return job.axes.size() == 3 && job.axes[2].parameter == parameter;
}

std::string f0_words(const JobSpec& job) {
    return along_z(job, Parameter::f0) ? "along z" : numbers(job.fresnel.f0);
}

/// Which channels no eta and k can have the metal's colour in.
std::string gamut_words(const MetalConstants& metal) {
    constexpr std::array names{"red", "green", "blue"};
    std::string words;
    for (std::size_t c = 0; c < names.size(); ++c) {
        if (metal.f0[c] <= 1) continue;
        const double k2 = metal.k[c] * metal.k[c];
        const double below = metal.eta[c] - 1, above = metal.eta[c] + 1;
        const double most = (below * below + k2) / (above * above + k2);
        words += std::string("; out of gamut: ") + names[c] + " would be " + number(metal.f0[c]) +
                 " at normal incidence and is capped at " + number(std::round(most * 1e4) / 1e4);
    }
    return words;
}

std::string conductor_words(const FresnelModel& f) {
    if (!f.metal) return ", exact, eta " + numbers(f.eta) + ", k " + numbers(f.k);
    const MetalConstants& metal = metal_constants(*f.metal);
    return ", exact, " + text(to_word(*f.metal)) + ": eta " + numbers(metal.eta) + ", k " +
           numbers(metal.k) + " in linear sRGB, from n and k of " + metal.source +
           " (CIE 1931, D65)" + gamut_words(metal);
}

}  // namespace

std::string fresnel_words(const JobSpec& job) {
    const FresnelModel& f = job.fresnel;
    const std::string exponent = number(f.model == Fresnel::schlick ? f.exponent : 5);
    if (!any(job, reads_fresnel))
        return any(job, is_split_sum) ? "schlick (1994), F = F0 + (F90 - F0)(1 - VoH)^" + exponent
                                      : "none";
    const std::string name = text(to_word(f.model));
    switch (f.model) {
        case Fresnel::none:
            return "none, F = 1";
        case Fresnel::schlick:
            return name + ", f0 " + f0_words(job) + ", f90 " + numbers(f.f90) + ", exponent " +
                   exponent;
        case Fresnel::dielectric:
            return name + ", exact, ior " +
                   (along_z(job, Parameter::ior) ? "along z" : numbers(f.ior));
        case Fresnel::conductor:
            return name + conductor_words(f);
        case Fresnel::edge_tint:
            return name + " (Gulbrandsen 2014), reflectivity " + numbers(f.reflectivity) +
                   ", edge tint " + numbers(f.edge_tint);
        case Fresnel::f82_tint:
            return name + " (Hoffman 2019, MaterialX), f0 " + f0_words(job) + ", f82 " +
                   numbers(f.f82);
    }
    return name;
}

std::string diffuse_words(const JobSpec& job) {
    if (!any(job, reads_diffuse)) return "none";
    const bool sigma = job.diffuse.model == DiffuseModel::oren_nayar ||
                       job.diffuse.model == DiffuseModel::oren_nayar_full;
    return text(to_word(job.diffuse.model)) + ", albedo " + numbers(job.diffuse.albedo) +
           (sigma ? ", the axis' roughness is sigma in radians" : "");
}

std::string distribution_words(Distribution distribution) {
    switch (distribution) {
        case Distribution::ggx:
            return "ggx (Walter et al. 2007)";
        case Distribution::beckmann:
            return "beckmann (Beckmann and Spizzichino 1963)";
        case Distribution::charlie:
            return "charlie (Estevez and Kulla 2017)";
    }
    return "";
}

std::string masking_words(const JobSpec& job) {
    switch (job.masking) {
        case Masking::smith_correlated:
            return "height-correlated Smith (Heitz 2014)";
        case Masking::smith_separable:
            return "separable Smith, G1(V) G1(L)";
        case Masking::karis_ibl:
            return "Schlick's G1 with k = alpha / 2 (Karis 2013)";
        case Masking::karis_direct:
            return "Schlick's G1 with k = (roughness + 1)^2 / 8 (Karis 2013)";
        case Masking::unreal_joint:
            return "Unreal 4's approximation of height-correlated Smith";
        case Masking::neubelt:
            return "1 / (4 (NoL + NoV - NoL NoV)) (Neubelt and Pettineo 2013)";
        case Masking::charlie:
            return std::string("fitted Smith of Charlie (Estevez and Kulla 2017)") +
                   (job.terminator_softening ? ", the light's term softened (eq. 4)" : "");
    }
    return "";
}

std::string multiscatter_words(Multiscatter multiscatter) {
    switch (multiscatter) {
        case Multiscatter::none:
            return "none";
        case Multiscatter::kulla_conty:
            return "kulla_conty (2017), (1 - E) F_avg^2 E_avg / (1 - F_avg (1 - E_avg))";
        case Multiscatter::kulla_conty_linear:
            return "kulla_conty_linear, (1 - E) F_avg E_avg / (1 - F_avg (1 - E_avg))";
        case Multiscatter::turquin:
            return "turquin (2019), single scattering times 1 + F(1) (1 - E) / E, F(1) at normal "
                   "incidence";
    }
    return "";
}

}  // namespace kiln
