// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "server/spec/closed_sets.h"  // cmake/Words.cmake

namespace kiln {

/// Seed of the method: L. Cezner 2024, "Utilizing Measured Reflectance for Real-time Rendering in
/// Game Engines", equations 12 and 13.
struct Extrapolation {
    double p = 1;    ///< what is left of f at the horizon, 0 or more; 1 clamps
    double l = 0.3;  ///< place of the Bezier curve's middle point (l, 1 - l), 0 … 1
    /// Beyond theta_in of the last measured incidence: clamp, the last lobe about the new mirror
    /// direction, or reciprocity, f(o, i) where that is measured and further on the last lobe at
    /// the level found there.
    ThetaInBeyond theta_in = ThetaInBeyond::reciprocity;
    bool operator==(const Extrapolation&) const = default;
};

/// A measurement and how it becomes a function of all directions.
struct MeasuredMaterial {
    std::string data;  ///< SHA-256 of the file, 64 hex digits
    std::string name;  ///< for people; the first digits of the hash unless the job has one
    Extrapolation extrapolation;
    /// Azimuth of the light in degrees, in [0, 360); the mean over all azimuths where there is
    /// none.
    std::optional<double> phi_in = std::nullopt;
    bool operator==(const MeasuredMaterial&) const = default;
};

/// What jobs of measured kinds are of. What a kind does not read is at its default.
struct MeasuredSpec {
    std::vector<MeasuredMaterial> materials;  ///< one, or up to atlas_materials_max in a list
    std::vector<double> theta_in;             ///< degrees, rising, in [0, 90]; one a slice or lobe
    std::int64_t gutter = 0;                  ///< texels around each cell
    bool conserve = false;                    ///< reciprocal and energy-conserving first
    /// Where parameters are within this of a material, they are offered; an atlas leaves it out.
    std::optional<double> fit_error_max;
    bool operator==(const MeasuredSpec&) const = default;
};

/// "sha256:" and 64 lower-case hex digits: how documents name a measurement.
inline constexpr const char* kMeasurementPrefix = "sha256:";

}  // namespace kiln
