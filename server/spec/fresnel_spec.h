// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <vector>

#include "server/spec/closed_sets.h"  // cmake/Words.cmake

namespace kiln {

/// A Fresnel model and its parameters. A vector that the model uses holds one value, or three for
/// linear RGB; the others are not looked at. Ranges: FresnelLimits in server/compute/fresnel.h.
struct FresnelModel {
    Fresnel model = Fresnel::schlick;
    std::vector<double> f0 = {0.04};           ///< schlick, f82_tint: reflectance at VoH = 1
    std::vector<double> f90 = {1};             ///< schlick: at VoH = 0
    double exponent = 5;                       ///< schlick
    std::vector<double> ior = {1.5};           ///< dielectric: n_t / n_i, < 1 in the denser medium
    std::vector<double> eta = {}, k = {};      ///< conductor: eta + i k, beside a medium of index 1
    std::optional<Metal> metal = {};           ///< conductor: three pairs, in place of eta and k
    std::vector<double> reflectivity = {0.5};  ///< edge_tint: reflectance at VoH = 1
    std::vector<double> edge_tint = {0};       ///< edge_tint: Gulbrandsen's g
    std::vector<double> f82 = {1};             ///< f82_tint: factor on Schlick's F at VoH = 1/7
    bool operator==(const FresnelModel&) const = default;
};

/// 3 when a number that the model reads has three values, else 1.
int channel_count(const FresnelModel& model);

}  // namespace kiln
