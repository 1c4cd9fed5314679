// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>

#include "server/spec/fresnel_spec.h"

namespace kiln {

/// Optical constants of a metal for the three channels of linear sRGB.
struct MetalConstants {
    Metal metal;
    std::array<double, 3> eta, k;
    /// Reflectance at normal incidence under D65. What is beyond the gamut may exceed 1, and then
    /// exceeds what eta and k give.
    std::array<double, 3> f0;
    const char* source;  ///< who measured the spectrum
};

const MetalConstants& metal_constants(Metal metal);

}  // namespace kiln
