// SPDX-License-Identifier: Apache-2.0
#include "server/measured/material.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "server/base/error.h"
#include "server/measured/colour.h"
#include "server/measured/resample.h"

namespace kiln::measured {
namespace {

/// Degrees past the edge that still count as within: 1e-5 radians, as in kernels/measured.h.
constexpr double kBeyondEdge = 1e-5 / kDegree;

/// Largest theta_o of the hull at each degree of azimuth.
std::vector<double> reach_of(const Hemisphere& hemisphere) {
    constexpr int kSteps = 180;
    std::vector<double> reach;
    std::vector<double> values(hemisphere.channels());
    std::uint32_t hint = 0;
    for (int azimuth = 0; azimuth < 360; ++azimuth) {
        double most = 0;
        for (int step = 0; step <= kSteps; ++step) {
            const double theta = 90.0 * step / kSteps;
            Origin origin{};
            if (hemisphere.value(direction(theta, azimuth), hint, values.data(), origin))
                most = theta;
        }
        for (double step = 90.0 / kSteps / 2; step > 0.005 && most < 90; step /= 2) {
            Origin origin{};
            const Vec out = direction(std::min(90.0, most + step), azimuth);
            if (hemisphere.value(out, hint, values.data(), origin))
                most = std::min(90.0, most + step);
        }
        reach.push_back(most);
    }
    return reach;
}

double between_degrees(const std::vector<double>& list, double azimuth) {
    const double at = wrapped_degrees(azimuth);
    const auto low = static_cast<std::size_t>(at);
    const double share = at - std::floor(at);
    return (1 - share) * list[low % 360] + share * list[(low + 1) % 360];
}

}  // namespace

double bezier(double x, double l) {
    // x = 2 (1 - t) t l + t^2 solved for t, without the pole where the curve is a line.
    const double q = 1 - 2 * l;
    const double root = std::sqrt(std::max(0.0, l * l + q * x));
    const double t = l + root > 0 ? x / (l + root) : 0.0;
    return 2 * (1 - t) * t * (1 - l) + t * t;
}

Material::Material(const Component& component, Extrapolation extrapolation, Understood& account,
                   PhiIn phi_in)
    : extrapolation_(extrapolation) {
    const Colouring colouring = colouring_of(component.cloud.channels);
    colour_ = colouring.words;
    std::vector<Incidence> incidences = incidences_of(component, usual_theta_in());
    for (Incidence& one : incidences) one.values = colouring.seen(one.values);
    if (component.symmetry == TurnSymmetry::any_turn) phi_in.reset();
    for (const Incidence& one : at_azimuth(incidences, component.symmetry, 3, phi_in, azimuths_)) {
        if (!lobes_.empty() && lobes_.back().theta_i == one.theta_i) continue;
        Hemisphere hemisphere(one, 3);
        if (!hemisphere.has_area()) continue;
        std::vector<double> reach = reach_of(hemisphere);
        lobes_.push_back({one.theta_i, std::move(hemisphere), std::move(reach)});
    }
    if (lobes_.empty())
        throw Error("unfit_measurement", "no incidence has three directions that span an area");
    // What a table may be off by without a word: the chain's own bound.
    constexpr double kTurns = 0.02;
    if (azimuths_.spread > kTurns)
        account.warn("the material turns: light from single azimuths differs from the table, for " +
                     (phi_in ? "phi_in = " + in_words(*phi_in) : "the mean of all azimuths") +
                     ", by " + in_words(100 * azimuths_.spread) + " % on the mean");
    if (phi_in) extrapolation_.theta_in = ThetaInBeyond::clamp;  // f(o, i) is of other azimuths
    find_floor();
    between_ = better_between(*this);
    stations_ = measured::stations(theta_in(), between_);
    find_levels();
}

void Material::find_floor() {
    double sum = 0, count = 0;
    for (std::size_t lobe = 0; lobe < lobes_.size(); ++lobe)
        for (double theta = 5; theta < 90; theta += 10)
            for (double phi = 0; phi < 360; phi += 20) {
                Origin origin{};
                const Colour c = lobe_value(lobe, direction(theta, phi), origin);
                sum += std::sin(2 * theta * kDegree) * (c[0] + c[1] + c[2]) / 3;
                count += std::sin(2 * theta * kDegree);
            }
    const double mean = sum / count;
    floor_ = mean > 0 ? 0.01 * mean : 1;
}

std::vector<double> Material::theta_in() const {
    std::vector<double> list;
    for (const Lobe& lobe : lobes_) list.push_back(lobe.theta_i);
    return list;
}

double Material::edge(std::size_t lobe, double azimuth) const {
    return between_degrees(lobes_[lobe].reach, azimuth);
}

Colour Material::edge_value(std::size_t lobe, Vec out, std::uint32_t& hint, Origin& origin) const {
    const Lobe& one = lobes_[lobe];
    Colour values;
    if (out.z >= 0 && one.hemisphere.value(out, hint, values.data(), origin)) return values;
    const double theta = std::min(theta_of(out), 90.0), phi = phi_of(out);
    const double last = edge(lobe, phi);
    // A hair inside, for the edge between two azimuths is no straight line.
    for (double back = 0; back <= 4; back += back < 0.2 ? 0.02 : 0.25)
        if (one.hemisphere.value(direction(std::max(0.0, std::min(theta, last) - back), phi), hint,
                                 values.data(), origin))
            return values;
    // An azimuth that nothing was measured at: the same angle across the plane.
    const double other = std::max(0.0, std::min(theta, edge(lobe, -phi)) - 0.02);
    if (!one.hemisphere.value(direction(other, -phi), hint, values.data(), origin)) return {};
    origin = Origin::kExtrapolated;
    return values;
}

double Material::tail(double theta_o, double edge) const {
    const double width = 90 - edge;
    const double place = width > 0 ? std::clamp((theta_o - edge) / width, 0.0, 1.0) : 1.0;
    const double a = bezier(place, extrapolation_.l);
    return (1 - a) + a * extrapolation_.p;
}

Colour Material::lobe_value(std::size_t lobe, Vec out, Origin& origin) const {
    std::uint32_t hint = Triangulation::kNone;
    Colour c = edge_value(lobe, out, hint, origin);
    const double theta = std::min(theta_of(out), 90.0), last = edge(lobe, phi_of(out));
    if (theta <= last + kBeyondEdge) return c;
    origin = Origin::kExtrapolated;
    for (double& v : c) v *= tail(theta, last);
    return c;
}

Colour Material::tapped(const std::vector<Tap>& taps, Vec about, Origin& origin) const {
    origin = Origin::kMeasured;
    const bool linear = taps.size() <= 2;
    Colour sum{};
    for (std::size_t n = 0; n < taps.size(); ++n) {
        const Tap& tap = taps[n];
        const Vec d = tap.turned ? Vec{-about.x, -about.y, about.z} : about;
        const Vec out = from_mirror(lobes_[tap.lobe].theta_i, d);
        std::uint32_t hint = Triangulation::kNone;
        Origin from{};
        const Colour c = edge_value(tap.lobe, out, hint, from);
        if (std::min(theta_of(out), 90.0) > edge(tap.lobe, phi_of(out)) + kBeyondEdge)
            from = Origin::kExtrapolated;
        if (n < 2) origin = std::max(origin, from);
        for (std::size_t k = 0; k < 3; ++k)
            sum[k] += tap.weight * (linear ? c[k] : std::asinh(c[k] / floor_));
    }
    if (!linear)
        for (double& v : sum) v = floor_ * std::sinh(v);
    return sum;
}

double Material::station_edge(const Station& station, double azimuth) const {
    if (station.taps.size() == 1) return edge(station.taps[0].lobe, azimuth);
    const std::size_t low = station.taps[0].lobe, high = station.taps[1].lobe;
    const double from = lobes_[low].theta_i;
    const double share = (station.theta_in - from) / (lobes_[high].theta_i - from);
    return (1 - share) * edge(low, azimuth) + share * edge(high, azimuth);
}

Colour Material::station_value(const Station& station, Vec about, Origin& origin) const {
    const Vec out = from_mirror(station.theta_in, about);
    if (station.taps.size() == 1) return lobe_value(station.taps[0].lobe, out, origin);
    Colour c = tapped(station.taps, about, origin);
    origin = std::max(origin, Origin::kInterpolated);
    const double theta = std::min(theta_of(out), 90.0), last = station_edge(station, phi_of(out));
    if (theta <= last + kBeyondEdge) return c;
    origin = Origin::kExtrapolated;
    for (double& v : c) v *= tail(theta, last);
    return c;
}

Colour Material::aligned_value(double theta_in, Vec out, Origin& origin) const {
    const Vec about = to_mirror(theta_in, out);
    const auto above = std::upper_bound(stations_.begin(), stations_.end(), theta_in,
                                        [](double t, const Station& s) { return t < s.theta_in; });
    if (above == stations_.begin()) return station_value(stations_.front(), about, origin);
    const Station& low = *(above - 1);
    if (above == stations_.end() || low.theta_in == theta_in) {
        const Colour c = station_value(low, about, origin);
        if (theta_in > low.theta_in) origin = Origin::kExtrapolated;
        return c;
    }
    Origin first{}, second{};
    const Colour a = station_value(low, about, first), b = station_value(*above, about, second);
    const double share = (theta_in - low.theta_in) / (above->theta_in - low.theta_in);
    origin = std::max({first, second, Origin::kInterpolated});
    Colour c{};
    for (std::size_t k = 0; k < 3; ++k) c[k] = (1 - share) * a[k] + share * b[k];
    return c;
}

/// Light beyond the last incidence: f(o, i) has its light at theta_o, which may be measured.
Colour Material::beyond_value(double theta_in, Vec out, Origin& origin) const {
    const double theta_o = theta_of(out);
    const Lobe& last = lobes_.back();
    if (theta_o <= last.theta_i && lobes_.size() > 1) {
        const Colour c = aligned_value(theta_o, direction(theta_in, -phi_of(out)), origin);
        if (origin != Origin::kExtrapolated) origin = Origin::kInterpolated;
        return c;
    }
    Colour c = aligned_value(theta_in, out, origin);
    const double scale = level(theta_in);
    for (double& v : c) v *= scale;
    origin = Origin::kExtrapolated;
    return c;
}

/// How much brighter f(o, i) is than the clamped lobe on the ring theta_o = theta_in_max(), where
/// both are known: the mean of its logarithm over azimuths.
void Material::find_levels() {
    if (extrapolation_.theta_in == ThetaInBeyond::clamp || lobes_.size() < 2) return;
    const double edge = theta_in_max();
    for (double theta_in = edge; theta_in < 91; theta_in += 1) {
        double sum = 0;
        int count = 0;
        for (int turn = 0; turn < 360; turn += 5) {
            Origin ignored{};
            const Vec out = direction(edge, turn);
            const double there =
                aligned_value(edge, direction(std::min(theta_in, 90.0), -turn), ignored)[1];
            const double clamped = aligned_value(std::min(theta_in, 90.0), out, ignored)[1];
            if (there > 0 && clamped > 0) {
                sum += std::log(there / clamped);
                ++count;
            }
        }
        levels_.push_back(count > 0 ? std::exp(sum / count) : 1.0);
    }
}

double Material::level(double theta_in) const {
    if (levels_.empty()) return 1;
    const double at =
        std::clamp(theta_in - theta_in_max(), 0.0, static_cast<double>(levels_.size() - 1));
    const auto low = static_cast<std::size_t>(at);
    const std::size_t high = std::min(low + 1, levels_.size() - 1);
    const double share = at - static_cast<double>(low);
    return (1 - share) * levels_[low] + share * levels_[high];
}

Colour Material::value(double theta_in, Vec out, Origin& origin) const {
    const bool below = out.z < 0;
    const Vec view = below ? direction(90, phi_of(out)) : out;
    const bool beyond = theta_in > theta_in_max() + 1e-9 && !levels_.empty();
    const Colour c =
        beyond ? beyond_value(theta_in, view, origin) : aligned_value(theta_in, view, origin);
    if (below) origin = Origin::kExtrapolated;
    return c;
}

Material::Albedo Material::albedo(double theta_in) const {
    return Resampler().albedos(make_lobe_tables(*this), std::array{theta_in}).front();
}

Material::Albedo Material::average_albedo() const {
    return Resampler().average_albedo(make_lobe_tables(*this));
}

}  // namespace kiln::measured
