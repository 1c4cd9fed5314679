// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <vector>

#include "server/measured/angles.h"
#include "server/measured/cloud.h"

namespace kiln::measured {

/// The points of a component under one direction of light, which stands at azimuth 0 here: views
/// are turned by -phi_i. Values are point-major as in the cloud.
struct Incidence {
    double theta_i = 0, phi_i = 0;  ///< degrees; phi_i as in the file
    std::vector<Vec> out;
    std::vector<PointState> state;
    std::vector<float> values;
    std::vector<float> patch;  ///< projected solid angle in sr, or empty
};

/// The incidences of a component, by theta_i and then phi_i. Angles that agree within a
/// thousandth of a degree are one. A table over half and difference angles is resampled at
/// `theta_in` (degrees), trilinearly among its valid cells, on half vectors as dense as its own;
/// other components ignore `theta_in`. Points below the horizon are dropped. Throws
/// Error("malformed_measurement") beyond kIncidencesMax.
std::vector<Incidence> incidences_of(const Component& component,
                                     const std::vector<double>& theta_in);

/// Where a component over half and difference angles is looked at if nobody asks otherwise.
std::vector<double> usual_theta_in();

}  // namespace kiln::measured
