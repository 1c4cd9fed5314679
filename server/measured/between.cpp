// SPDX-License-Identifier: Apache-2.0
#include "server/measured/between.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "server/measured/material.h"

namespace kiln::measured {
namespace {

/// Where a tap's light stands, negative where it is turned.
double place_of(std::span<const double> incidences, const Tap& tap) {
    return tap.turned ? -incidences[tap.lobe] : incidences[tap.lobe];
}

/// Weights of three places in the slope at t of the parabola through them.
std::array<double, 3> slope_weights(const std::array<double, 3>& x, double t) {
    const auto one = [&](std::size_t a, std::size_t b, std::size_t c) {
        return (2 * t - x[b] - x[c]) / ((x[a] - x[b]) * (x[a] - x[c]));
    };
    return {one(0, 1, 2), one(1, 2, 0), one(2, 0, 1)};
}

/// A cubic Hermite curve from taps[0] to taps[1]; each end's slope is that of the parabola through
/// it and its neighbours, or of the one parabola there is.
void set_cubic(std::span<const double> incidences, double theta_in, int before, int after,
               std::vector<Tap>& taps) {
    const auto at = [&](int tap) {
        return place_of(incidences, taps[static_cast<std::size_t>(tap)]);
    };
    const double from = at(0), width = at(1) - from, u = (theta_in - from) / width;
    taps[0].weight = (2 * u - 3) * u * u + 1;
    taps[1].weight = 1 - taps[0].weight;
    const auto add = [&](std::array<int, 3> of, int end, double share) {
        const std::array<double, 3> slope =
            slope_weights({at(of[0]), at(of[1]), at(of[2])}, at(end));
        for (std::size_t k = 0; k < 3; ++k)
            taps[static_cast<std::size_t>(of[k])].weight += share * width * slope[k];
    };
    const int low = before >= 0 ? before : after, high = after >= 0 ? after : before;
    add({low, 0, 1}, 0, ((u - 2) * u + 1) * u);
    add({0, 1, high}, 1, (u - 1) * u * u);
}

/// Views even in projected solid angle: the golden spiral on the disk.
std::vector<Vec> views() {
    constexpr int kViews = 1500;
    std::vector<Vec> list;
    for (int v = 0; v < kViews; ++v) {
        const double r2 = (v + 0.5) / kViews, turn = 360 * 0.6180339887498949 * v;
        list.push_back(direction(std::asin(std::sqrt(r2)) / kDegree, turn));
    }
    return list;
}

double sum_of(const Colour& c) { return c[0] + c[1] + c[2]; }

double left_out(const Material& material, std::size_t lobe, std::vector<Tap> taps) {
    for (Tap& tap : taps) tap.lobe += tap.lobe >= lobe;  // of the list that lacks it
    const double theta_in = material.theta_in()[lobe];
    double off = 0, all = 0;
    for (const Vec& out : views()) {
        Origin origin{}, there{};
        const Colour predicted = material.tapped(taps, to_mirror(theta_in, out), origin);
        const Colour f = material.lobe_value(lobe, out, there);
        if (std::max(origin, there) == Origin::kExtrapolated) continue;
        off += std::abs(sum_of(predicted) - sum_of(f));
        all += std::abs(sum_of(f));
    }
    return all > 0 ? off / all : 0;
}

}  // namespace

std::string to_string(Between between) { return between == Between::linear ? "linear" : "cubic"; }

std::vector<Tap> taps_at(std::span<const double> incidences, double theta_in, Between between) {
    const std::size_t count = incidences.size();
    const auto above = std::upper_bound(incidences.begin(), incidences.end(), theta_in);
    if (above == incidences.begin()) return {{0, false, 1}};
    const auto low = static_cast<std::size_t>(above - incidences.begin()) - 1;
    if (low + 1 == count || incidences[low] == theta_in) return {{low, false, 1}};
    std::vector<Tap> taps = {{low, false, 0}, {low + 1, false, 0}};
    if (between == Between::linear) {
        taps[1].weight = (theta_in - incidences[low]) / (incidences[low + 1] - incidences[low]);
        taps[0].weight = 1 - taps[1].weight;
        return taps;
    }
    int before = -1, after = -1;
    const auto take = [&](std::size_t lobe, bool turned) {
        taps.push_back({lobe, turned, 0});
        return static_cast<int>(taps.size()) - 1;
    };
    if (low > 0)
        before = take(low - 1, false);
    else
        before = take(incidences[0] > 0 ? 0 : 1, true);
    if (low + 2 < count) after = take(low + 2, false);
    set_cubic(incidences, theta_in, before, after, taps);
    return taps;
}

std::vector<Station> stations(std::span<const double> incidences, Between between) {
    std::vector<Station> list;
    for (std::size_t n = 0; n < incidences.size(); ++n) {
        list.push_back({incidences[n], {{n, false, 1}}});
        if (n + 1 == incidences.size() || between == Between::linear) continue;
        const double gap = incidences[n + 1] - incidences[n];
        const int parts = static_cast<int>(std::ceil(gap / kStationStep - 1e-6));
        for (int k = 1; k < parts; ++k) {
            const double theta_in = incidences[n] + gap * k / parts;
            list.push_back({theta_in, taps_at(incidences, theta_in, between)});
        }
    }
    return list;
}

Reach reach_of(std::span<const double> incidences, double theta_in, Between between) {
    double product = 1;
    const std::vector<Tap> taps = taps_at(incidences, theta_in, between);
    for (const Tap& tap : taps) product *= std::abs(theta_in - place_of(incidences, tap));
    const auto order = static_cast<double>(taps.size());
    return {std::pow(product, 1 / order), order};
}

std::vector<IncidenceError> leave_incidences_out(const Material& material, Between between) {
    const std::vector<double> all = material.theta_in();
    std::vector<IncidenceError> list;
    for (std::size_t n = 1; n + 1 < all.size(); ++n) {
        std::vector<double> others = all;
        others.erase(others.begin() + static_cast<std::ptrdiff_t>(n));
        list.push_back({n, left_out(material, n, taps_at(others, all[n], between)),
                        reach_of(others, all[n], between).length});
    }
    return list;
}

Between better_between(const Material& material) {
    double sum[2] = {};
    for (const Between between : {Between::linear, Between::cubic})
        for (const IncidenceError& one : leave_incidences_out(material, between))
            sum[between == Between::cubic] += one.error;
    return sum[1] < sum[0] ? Between::cubic : Between::linear;
}

}  // namespace kiln::measured
