// SPDX-License-Identifier: Apache-2.0
#include "server/compute/quadrature_integrals.h"

#include <algorithm>
#include <optional>

#include "server/compute/fresnel.h"
#include "server/compute/quadrature.h"
#include "server/compute/quadrature_job.h"

namespace kiln {

namespace {

/// The scalars of a channel's Fresnel term, and the diffuse albedo.
QuadratureParameters parameters_of(const Pass& pass, std::size_t colour) {
    QuadratureParameters parameters;
    std::copy_n(pass.parameters.begin() + static_cast<std::ptrdiff_t>(colour * kFresnelParameters),
                kFresnelParameters, parameters.begin());
    parameters.back() = pass.parameters[kAlbedoParameter + colour];
    return parameters;
}

/// A conductor of k = 0 is a dielectric, whose rule knows where total reflection begins.
std::optional<QuadratureParameters> without_absorption(int fresnel,
                                                       const QuadratureParameters& numbers) {
    const double contrast = numbers[0], square = numbers[1], loss = numbers[2];
    if (fresnel != fresnel_function({.model = Fresnel::conductor}) || loss != 0 || !(square > 0))
        return {};
    QuadratureParameters clear{contrast, square, contrast == 0 ? 0.0 : 1.0};
    clear.back() = numbers.back();
    return clear;
}

/// Charlie's masking is exp L with L up to 20, of which half a unit in float is 1e-6.
Precision precision_of(const JobSpec& job, const KernelMaterial& lobe) {
    return is_charlie_fit(lobe.masking) ? Precision::float64 : job.precision;
}

std::vector<Integral> diffuse_integrals_of(const JobSpec& job, const Pass& pass) {
    const KernelMaterial& material = pass.what.material;
    // Averages are integrated in double, as their deficits are.
    const Precision precision = material.averaged ? Precision::float64 : job.precision;
    std::vector<Integral> list;
    for (std::size_t colour = 0; colour < 3; ++colour)
        for (const std::size_t first : {kDiffuse, kTransmitted}) {
            const std::size_t term = first + colour;
            if (!(material.terms >> term & 1)) continue;
            const int fresnel = first == kTransmitted ? material.fresnel : kNoFresnel;
            list.push_back({{DiffuseRule{material.diffuse, fresnel}, precision},
                            term,
                            parameters_of(pass, colour)});
        }
    return list;
}

}  // namespace

bool walks(const Pass& pass) {
    return pass.what.material.diffuse ==
           static_cast<int>(DiffuseModel::ggx_lambert) - static_cast<int>(DiffuseModel::lambert);
}

std::vector<Integral> integrals_of(const JobSpec& job, const Pass& pass) {
    const KernelMaterial& material = pass.what.material;
    if (std::vector<Integral> matte = diffuse_integrals_of(job, pass); !matte.empty()) return matte;
    if (material.averaged) return {{quadrature_average_kind(material), kWeight, {}}};
    std::vector<Integral> list;
    const auto add = [&](std::size_t term, int fresnel, const QuadratureParameters& parameters) {
        list.push_back({quadrature_kind(material, fresnel, parameters, precision_of(job, material)),
                        term, parameters});
    };
    if (material.terms & 1 << kSchlick) {
        const double exponent = pass.parameters[kExponentParameter];
        if (exponent == 5)
            add(kSchlick, kSchlickWeight, {});
        else
            add(kSchlick, kSchlickPower, {0, 1, exponent});
    }
    for (std::size_t colour = 0; colour < 3; ++colour) {
        if (!(material.terms & 1 << (kColour + colour))) continue;
        const QuadratureParameters numbers = parameters_of(pass, colour);
        if (const auto clear = without_absorption(material.fresnel, numbers))
            add(kColour + colour, fresnel_function({.model = Fresnel::dielectric}), *clear);
        else
            add(kColour + colour, material.fresnel, numbers);
    }
    if (list.empty()) add(kWeight, kNoFresnel, {});
    return list;
}

std::vector<KernelKind> quadrature_kernels(const JobSpec& job, const Plan& plan) {
    std::vector<KernelKind> kernels;
    for (const Pass& pass : plan.passes) {
        if (walks(pass)) continue;
        for (const Integral& integral : integrals_of(job, pass)) kernels.push_back(integral.kind);
    }
    return kernels;
}

}  // namespace kiln
