// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <vector>

namespace kiln::measured {

class Material;

/// What a table of a material is off by, estimated from the measurement alone. Errors are mean
/// |difference| cos(theta_o) relative to the mean of f cos(theta_o), of the channels' sum, within
/// the measured part.
///
/// Points: a point and all within three quarters of its longest edge are left out and it is
/// predicted from the rest. Of a function of constant curvature a triangulation is off by a sixth
/// of that on the mean. Incidences: each inner one is predicted from the others as the table goes
/// on between them (between.h), about the mirror direction; in a gap the error is that one by the
/// ratio of the products of distances (Reach).
struct PredictedError {
    double points = 0;    ///< at measured incidences
    double theta_in = 0;  ///< what is added between them; 0 where there are fewer than three
    double azimuths =
        0;              ///< between azimuths of the light, or of their mean: AzimuthAccount::error
    double table = 0;   ///< of the slices' texels, linearly interpolated; 0 without slices
    double slices = 0;  ///< what the linear way between slices adds; 0 without
    bool knows_theta_in = false;

    double at_incidences() const { return points + azimuths + table; }
    double between_incidences() const { return at_incidences() + theta_in + slices; }
};
PredictedError predict_error(const Material& material);

/// The same by parts, for who wants to see where.
double points_error(const Material& material, std::size_t lobe);
/// Of every gap between incidences; empty for fewer than three.
std::vector<double> theta_in_errors(const Material& material);

}  // namespace kiln::measured
