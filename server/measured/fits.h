// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <string>

#include "server/compute/table.h"
#include "server/measured/resample.h"

namespace kiln::measured {

enum class FitModel {
    /// diffuse / pi + D V (f0 + (f90 - f0) (1 - VoH)^5), GGX with Smith's correlated masking
    ggx_diffuse,
    /// diffuse / pi + f0 (n + 2) / (2 pi) max(0, v . r)^n (Lafortune and Willems 1994)
    lafortune_phong,
};

struct Fit {
    FitModel model = FitModel::ggx_diffuse;
    double width = 1;        ///< alpha, or the exponent n
    Colour diffuse{}, f0{};  ///< 0 or more; f0 is k_s of the Phong model
    double f90 = 1;          ///< of GGX; other than 1 where that leaves much less error
    double error = 0;        ///< mean |fit - f| cos(theta_o) over mean f cos(theta_o)
    double error_worst = 0;  ///< of the worst incidence
};

/// f_r of a fit, R, G, B.
Colour fitted_value(const Fit& fit, double theta_in, Vec out);

/// The best parameters over the measured part of all incidences: the linear ones exactly for each
/// width (Golub and Pereyra 1973), no negative ones, and the width by a scan and golden sections.
/// Squares are weighed by 1 / (f + a tenth of its mean), between absolute and relative.
Fit fit_model(FitModel model, const LobeTables& tables, Resampler& resampler);

/// (fit - f) / (f + a hundredth of the slice's largest f) at each texel of slices about the mirror
/// direction, theta_in downwards; one channel "error", 0 below the horizon and where nothing was
/// measured.
Table error_map(const Fit& fit, const LobeTables& tables, const std::vector<double>& theta_in,
                std::size_t width, std::size_t height, Resampler& resampler);

/// The GGX fit where it is within `error_asked`: parameters in place of a table.
std::optional<Fit> offered(const LobeTables& tables, double error_asked, Resampler& resampler);

std::string to_string(FitModel model);

}  // namespace kiln::measured
