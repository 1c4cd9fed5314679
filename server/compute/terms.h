// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstddef>

#include "kernels/words.h"  // cmake/Words.cmake

namespace kiln {

/// The sums that the kernels can make, by index; 1 << index is its KILN_TERM_ bit
/// (kernels/integrand.h, kernels/material.h). From kColour on, each stands for R and is followed by
/// G and B.
enum Term : std::size_t {
    kWeight = 0,       ///< f NoL / pdf with F = 1: its mean is E
    kSchlick = 1,      ///< (1 − VoH)^n of it: its mean is B
    kDeficit = 2,      ///< its mean is 1 − E, summed as such
    kColour = 3,       ///< F(VoH) f NoL / pdf
    kDiffuse = 6,      ///< π f_d under cosine sampling
    kTransmitted = 9,  ///< (1 − F(VoH)) π f_d
};
inline constexpr std::size_t kTermCount = 12;

/// The masking by which the kernels know charlie with terminator_softening; it has no word.
inline constexpr int kCharlieSoftened = KILN_MASKING_COUNT;
constexpr bool is_charlie_fit(int masking) {
    return masking == KILN_MASKING_CHARLIE || masking == kCharlieSoftened;
}

/// Numbers of the material that a launch carries (kernels/material.h): Fresnel's of three channels,
/// the diffuse albedo of each, Schlick's exponent of the split sum.
inline constexpr std::size_t kAlbedoParameter = 24;
inline constexpr std::size_t kExponentParameter = kAlbedoParameter + 3;
inline constexpr std::size_t kParameterCount = kExponentParameter + 1;

/// Parameters that no model objects to, for launches that compare devices and not materials.
template <typename Scalar>
std::array<Scalar, kParameterCount> any_parameters() {
    std::array<Scalar, kParameterCount> parameters;
    for (std::size_t p = 0; p < kParameterCount; ++p)
        parameters[p] = static_cast<Scalar>(1.25 + 0.125 * static_cast<double>(p % 8));
    return parameters;
}

/// A linear combination of term means.
using Combination = std::array<double, kTermCount>;

constexpr int terms_of(const Combination& combination) {
    int terms = 0;
    for (std::size_t t = 0; t < kTermCount; ++t)
        if (combination[t] != 0) terms |= 1 << t;
    return terms;
}

}  // namespace kiln
