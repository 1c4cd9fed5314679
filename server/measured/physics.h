// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <vector>

#include "server/compute/table.h"
#include "server/measured/resample.h"

namespace kiln::measured {

/// What image-based lighting needs of a measured material beside a prefiltered environment: in
/// split-sum form the light that leaves towards the view is E(NoV) times that environment. By
/// reciprocity E is the directional albedo for light from there.
struct Companion {
    Table table;  ///< one row; texel x is NoV = (x + 0.5) / width; R, G, B, extrapolated share
    Material::Albedo average;
};
Companion companion_of(const LobeTables& tables, std::size_t width, Resampler& resampler);

/// |f(i, o) - f(o, i)| over a fixed set of pairs that is even in projected solid angle of both, of
/// the channels' sum.
struct Reciprocity {
    double l1 = 0;      ///< mean difference relative to the mean of f
    double median = 0;  ///< of the differences relative to their pair's mean
    double p95 = 0;
};
struct Physics {
    /// Degrees: every 5 from 0 to 90, and the measured incidences.
    std::vector<double> theta_in;
    std::vector<Material::Albedo> albedo;            ///< at these
    double albedo_max = 0, albedo_max_theta_in = 0;  ///< of all channels
    double extrapolated = 0;                         ///< share of the average albedo
    Reciprocity all;                                 ///< over the whole hemispheres
    Reciprocity measured;       ///< pairs where neither value lies beyond the measurement
    double measured_pairs = 0;  ///< their share
};
Physics physics_of(const LobeTables& tables, Resampler& resampler);

/// Makes a material reciprocal and energy-conserving: f becomes the mean of f(i, o) and f(o, i),
/// the nearest reciprocal function in the mean square, times s(theta_i) s(theta_o) <= 1, which
/// leaves it reciprocal and takes every albedo to 1 at most. Returns s, one a degree; all 1 where
/// the mean conserves energy already. Colours keep their hue.
std::vector<double> conserve(LobeTables& tables, Resampler& resampler);

}  // namespace kiln::measured
