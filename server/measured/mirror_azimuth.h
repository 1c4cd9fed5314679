// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "server/measured/reader.h"

namespace kiln::measured {

/// Adds the azimuth of the light to phi_i of a cloud in absolute angles. What the format says,
/// `usual` in degrees, is held against where the cloud is brightest at its largest incidence: a
/// lobe a quarter turn or more away from there moves it, with a warning. The person's word in
/// `options` decides over both.
void settle_light_azimuth(Cloud& cloud, double usual, const ReadOptions& options,
                          Understood& account);

}  // namespace kiln::measured
