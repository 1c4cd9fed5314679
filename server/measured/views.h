// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "server/measured/canvas.h"
#include "server/measured/resample.h"

namespace kiln::measured {

/// The reflection lobe under light at theta_in degrees (Cezner 2024, figure 4a): a surface whose
/// distance from the origin is f_r in each direction (its cube root where the peak is more than 20
/// times the mean), the peak scaled to 1, in the material's colour, dark where nothing was
/// measured. The light comes from the left. A PNG of `size` by 3/4 `size` pixels.
std::string lobe_view(const LobeTables& tables, double theta_in, std::size_t size,
                      Resampler& resampler);

/// A sphere of the material under two lamps and a sky, of which E(NoV) times its light from the
/// mirror direction is taken (the split sum). A PNG of `size` pixels square.
std::string sphere_view(const LobeTables& tables, std::size_t size, Resampler& resampler);

}  // namespace kiln::measured
