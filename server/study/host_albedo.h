// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>

#include "server/compute/native_group.h"

namespace kiln {

/// Integral of `value` over [from, to] by bisection, each half by Gauss-Legendre rules of 10 and 20
/// nodes, until they agree within `absolute`; at most some hundred halvings.
double adaptive_integral(const std::function<double(double)>& value, double from, double to,
                         double absolute);

/// A Fresnel term, and where it has a kink in VoH: where total reflection begins.
struct HostFresnel {
    std::function<double(double VoH)> F;
    double kink = 0;
};

/// E and B of a microfacet lobe (with F = 1, and with `fresnel`, else (1 - VoH)^5) over half
/// vectors, of the kernels' D and visibility in double: slow, and no sampler. alpha > 0.
struct HostAlbedo {
    double E = 0, B = 0;
};
HostAlbedo host_albedo(const KernelMaterial& lobe, double NoV, double alpha, double absolute,
                       const HostFresnel& fresnel = {});

/// Albedo of a diffuse model, of the kernels' pi f in double.
double host_diffuse_albedo(int model, double NoV, double roughness, double albedo, double absolute);

/// What white Lambertian GGX facets (ggx_lambert) send out after one of them: of light that is
/// reflected once and leaves, Heitz and Dupuy 2015. alpha > 0; NoV in [0, 1].
double host_single_facet_albedo(double NoV, double alpha, double absolute);

}  // namespace kiln
