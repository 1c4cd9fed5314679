// SPDX-License-Identifier: Apache-2.0
#include "server/measured/cloud.h"

#include <cmath>

#include "server/base/error.h"
#include "server/measured/bounds.h"

namespace kiln::measured {

double wrapped_degrees(double degrees) {
    const double turn = std::fmod(degrees, 360.0);
    const double wrapped = turn < 0 ? turn + 360.0 : turn;
    return wrapped >= 360.0 ? 0.0 : wrapped;
}

void add_point(Cloud& cloud, const Directions& at, const double* values, PointState state) {
    const std::size_t channels = cloud.channels.size();
    if (cloud.size() >= kPointsMax || (cloud.size() + 1) * channels > kValuesMax)
        throw Error("measurement_too_large", "more than " + std::to_string(kPointsMax) +
                                                 " points or " + std::to_string(kValuesMax) +
                                                 " values");
    const bool below = at.theta_o > 90.0 + 1e-4 || at.theta_i > 90.0 + 1e-4;
    cloud.theta_i.push_back(static_cast<float>(at.theta_i));
    cloud.phi_i.push_back(static_cast<float>(wrapped_degrees(at.phi_i)));
    cloud.theta_o.push_back(static_cast<float>(at.theta_o));
    cloud.phi_o.push_back(static_cast<float>(wrapped_degrees(at.phi_o)));
    cloud.state.push_back(below ? PointState::kBelowHorizon : state);
    for (std::size_t c = 0; c < channels; ++c)
        cloud.values.push_back(static_cast<float>(values[c]));
}

bool mirror_half(Cloud& cloud) {
    constexpr double kInPlane = 1e-3;  // degrees
    std::size_t left = 0, right = 0;
    for (std::size_t n = 0; n < cloud.size(); ++n) {
        const double turn = wrapped_degrees(cloud.phi_o[n] - cloud.phi_i[n]);
        if (cloud.theta_o[n] < kInPlane || cloud.theta_i[n] < kInPlane) continue;
        left += turn > kInPlane && turn < 180.0 - kInPlane;
        right += turn > 180.0 + kInPlane && turn < 360.0 - kInPlane;
    }
    if ((left > 0) == (right > 0)) return false;
    const std::size_t count = cloud.size();
    const std::size_t channels = cloud.channels.size();
    std::vector<double> values(channels);
    for (std::size_t n = 0; n < count; ++n) {
        const double turn = wrapped_degrees(cloud.phi_o[n] - cloud.phi_i[n]);
        const double off = std::fmod(turn, 180.0);
        if (off < kInPlane || off > 180.0 - kInPlane) continue;
        for (std::size_t c = 0; c < channels; ++c) values[c] = cloud.values[n * channels + c];
        const PointState state = usable(cloud.state[n]) ? PointState::kMirrored : cloud.state[n];
        add_point(cloud,
                  {cloud.theta_i[n], cloud.phi_i[n], cloud.theta_o[n], cloud.phi_i[n] - turn},
                  values.data(), state);
    }
    return true;
}

}  // namespace kiln::measured
