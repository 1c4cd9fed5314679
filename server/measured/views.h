// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <utility>
#include <vector>

#include "server/compute/table.h"
#include "server/measured/canvas.h"
#include "server/measured/resample.h"

namespace kiln::measured {

/// How large a picture is, and what it is called.
struct Frame {
    std::size_t width = 640, height = 480;  ///< pixels
    std::string title;                      ///< UTF-8, may be empty
};

struct View {
    Picture picture;
    std::vector<Words> words;
    double f_max = 0;        ///< of a lobe: the longest direction, 1/sr
    bool cube_root = false;  ///< of a lobe: how lengths go with f_r
};

/// The reflection lobe under light at theta_in degrees (Cezner 2024, figure 4a): a surface whose
/// distance from the origin is f_r in each direction (its cube root where the peak is more than 20
/// times the mean), the peak scaled to 1, in the material's colour, dark where nothing was
/// measured. The light comes from the left.
View lobe_view(const LobeTables& tables, double theta_in, const Frame& frame, Resampler& resampler);

/// A sphere of the material under two lamps and a sky, of which E(NoV) times its light from the
/// mirror direction is taken (the split sum).
View sphere_view(const LobeTables& tables, const Frame& frame, Resampler& resampler);

/// Maps of error_map() side by side, each of slices under `theta_in` downwards: red where a fit is
/// brighter than the measurement, blue where it is darker, in full at a half; white elsewhere.
View error_view(const std::vector<std::pair<std::string, Table>>& maps,
                const std::vector<double>& theta_in);

/// What is to be told of a lobe under light where no incidence was measured nearby; "" between the
/// first and the last.
std::string beyond_measured(const Material& material, double theta_in);

}  // namespace kiln::measured
