// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <vector>

#include "server/measured/incidence.h"

namespace kiln::measured {

/// Where a table's light stands about the normal, for it has one lobe for each theta_in: an azimuth
/// in degrees, or, where there is none, the mean over all azimuths.
using PhiIn = std::optional<double>;

/// Widest gap in degrees that a value may come from both sides of.
inline constexpr double kAzimuthGapMax = 90;

/// What became of the azimuths of a file.
struct AzimuthAccount {
    std::size_t measured = 1;  ///< the most of them under one theta_in
    /// Of single azimuths from what the table holds, relative: mean |difference| cos(theta_o) by
    /// mean f cos(theta_o), of the channels' sum. 0 of an isotropic file.
    double spread = 0;
    double error = 0;        ///< the same of what the table holds from the truth, predicted
    bool at_halves = false;  ///< values of one half vector went together, not of one place about
                             ///< the mirror direction: what predicts left-out azimuths better
};

/// One incidence for each theta_in, its light at phi_in: of several azimuths either their mean or
/// what lies between those beside phi_in, cubic where four are near enough. An azimuth that
/// `symmetry` gives counts as measured, and light along the normal stands at all of them. An only
/// azimuth of a theta_in stays as it is. `incidences` are as incidences_of() gives them, with
/// `channels` values a point. Throws
/// Error("unfit_measurement") where phi_in is between no azimuths of a theta_in.
std::vector<Incidence> at_azimuth(const std::vector<Incidence>& incidences, TurnSymmetry symmetry,
                                  std::size_t channels, PhiIn phi_in, AzimuthAccount& account);

}  // namespace kiln::measured
