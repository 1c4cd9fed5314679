// SPDX-License-Identifier: Apache-2.0
#include "server/measured/incidence.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "server/base/error.h"
#include "server/measured/bounds.h"

namespace kiln::measured {
namespace {

/// Along one axis of a table: two cells and the share of the second.
struct Between {
    std::size_t low = 0, high = 0;
    double share = 0;
};

/// Between the centres of `count` cells; `place` is in cells. Wraps or ends.
Between between(double place, std::size_t count, bool wraps) {
    const double at = place - 0.5;
    const double floor = std::floor(at);
    const auto n = static_cast<double>(count);
    const auto index = [&](double i) {
        const double held = wraps ? i - n * std::floor(i / n) : std::clamp(i, 0.0, n - 1);
        return static_cast<std::size_t>(held);
    };
    return {index(floor), index(floor + 1), at - floor};
}

/// Trilinear look-up with the weights of unusable cells left out and the rest made to sum to 1.
/// False where no usable cell has a weight.
bool look_up(const Component& table, Vec in, Vec out, double* values) {
    Vec half = in + out;
    const double length = std::sqrt(dot(half, half));
    half = (1 / length) * half;
    const double theta_h = theta_of(half), phi_h = phi_of(half) * kDegree;
    const double c = std::cos(phi_h), s = std::sin(phi_h);
    // The light turned by -phi_h about z, then by -theta_h about y.
    const Vec turned = {c * in.x + s * in.y, -s * in.x + c * in.y, in.z};
    const double ch = std::cos(theta_h * kDegree), sh = std::sin(theta_h * kDegree);
    const Vec difference = {ch * turned.x - sh * turned.z, turned.y, sh * turned.x + ch * turned.z};
    const auto [h_cells, d_cells, p_cells] = table.grid;
    const double phi_d = wrapped_degrees(phi_of(difference));
    const double cells_a_degree = 1.0;
    const Between h =
        between(std::sqrt(theta_h / 90) * static_cast<double>(h_cells), h_cells, false);
    const Between d =
        between(theta_of(difference) / 90 * static_cast<double>(d_cells), d_cells, false);
    const Between p = between(phi_d * cells_a_degree, p_cells, true);
    const std::size_t channels = table.cloud.channels.size();
    std::fill(values, values + channels, 0.0);
    double sum = 0;
    for (int corner = 0; corner < 8; ++corner) {
        const auto pick = [&](const Between& b, int bit) {
            const bool upper = (corner >> bit & 1) != 0;
            return std::pair(upper ? b.high : b.low, upper ? b.share : 1 - b.share);
        };
        const auto [ih, wh] = pick(h, 0);
        const auto [id, wd] = pick(d, 1);
        const auto [ip, wp] = pick(p, 2);
        const std::size_t n = (ih * d_cells + id) * p_cells + ip;
        const double weight = wh * wd * wp;
        if (weight <= 0 || !usable(table.cloud.state[n])) continue;
        sum += weight;
        for (std::size_t k = 0; k < channels; ++k) values[k] += weight * table.cloud.at(n)[k];
    }
    if (sum <= 1e-9) return false;
    for (std::size_t k = 0; k < channels; ++k) values[k] /= sum;
    return true;
}

Incidence resampled(const Component& table, double theta_i) {
    Incidence result;
    result.theta_i = theta_i;
    const Vec in = direction(theta_i, 0);
    const std::size_t channels = table.cloud.channels.size();
    std::vector<double> values(channels);
    constexpr int kAzimuths = 180;
    const auto rings = static_cast<int>(table.grid.theta_h);
    for (int ring = 0; ring <= rings; ++ring)
        for (int step = 0; step < (ring == 0 ? 1 : kAzimuths); ++step) {
            const double root = static_cast<double>(ring) / rings;
            const Vec half = direction(90.0 * root * root, 360.0 * step / kAzimuths);
            const Vec out = 2 * dot(in, half) * half - in;
            if (out.z <= 1e-3) continue;
            const bool found = look_up(table, in, out, values.data());
            result.out.push_back(out);
            result.state.push_back(found ? PointState::kMeasured : PointState::kNotMeasured);
            for (std::size_t k = 0; k < channels; ++k)
                result.values.push_back(static_cast<float>(found ? values[k] : 0.0));
        }
    return result;
}

}  // namespace

std::vector<double> usual_theta_in() { return {0, 15, 30, 45, 60, 75}; }

std::vector<Incidence> incidences_of(const Component& component,
                                     const std::vector<double>& theta_in) {
    const Cloud& cloud = component.cloud;
    std::vector<Incidence> list;
    if (component.grid.phi_d > 0) {
        for (const double theta_i : theta_in) list.push_back(resampled(component, theta_i));
        return list;
    }
    const auto thousandth = [](float degrees) { return std::lround(1000.0 * degrees); };
    std::map<std::array<long, 2>, std::size_t> index;
    for (std::size_t n = 0; n < cloud.size(); ++n) {
        if (cloud.state[n] == PointState::kBelowHorizon) continue;
        // Light along the normal has no azimuth, and views keep theirs.
        const long theta = thousandth(cloud.theta_i[n]);
        const auto [at, is_new] = index.try_emplace({theta, thousandth(cloud.phi_i[n])}, 0);
        if (is_new && index.size() > kIncidencesMax)
            throw Error("malformed_measurement",
                        "more than " + std::to_string(kIncidencesMax) + " directions of light");
    }
    for (auto& [key, place] : index) {
        place = list.size();
        list.emplace_back();
        list.back().theta_i = static_cast<double>(key[0]) / 1000;
        list.back().phi_i = static_cast<double>(key[1]) / 1000;
    }
    const std::size_t channels = cloud.channels.size();
    for (std::size_t n = 0; n < cloud.size(); ++n) {
        if (cloud.state[n] == PointState::kBelowHorizon) continue;
        Incidence& one = list[index.at({thousandth(cloud.theta_i[n]), thousandth(cloud.phi_i[n])})];
        one.out.push_back(direction(cloud.theta_o[n], cloud.phi_o[n] - cloud.phi_i[n]));
        one.state.push_back(cloud.state[n]);
        one.values.insert(one.values.end(), cloud.at(n), cloud.at(n) + channels);
        if (!cloud.patch.empty()) one.patch.push_back(cloud.patch[n]);
    }
    return list;
}

}  // namespace kiln::measured
