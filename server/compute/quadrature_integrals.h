// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <vector>

#include "server/compute/plan.h"
#include "server/compute/quadrature_launch.h"

namespace kiln {

/// One run of the kernel: E and the deficit, and the term that it adds to them (or kWeight). Of a
/// diffuse lobe the term alone.
struct Integral {
    QuadratureKind kind;
    std::size_t term = kWeight;
    QuadratureParameters parameters{};
};

/// Whether light walks over facets in a pass (ggx_lambert): no kernel integrates that.
bool walks(const Pass& pass);

/// The runs that a pass takes, one for each Fresnel term in it.
std::vector<Integral> integrals_of(const JobSpec& job, const Pass& pass);

}  // namespace kiln
