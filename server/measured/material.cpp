// SPDX-License-Identifier: Apache-2.0
#include "server/measured/material.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "server/base/error.h"
#include "server/measured/bounds.h"

namespace kiln::measured {
namespace {

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

/// Rows (-c, 0, -s), (0, -1, 0), (-s, 0, c), equation 15 of Cezner 2024: its own inverse's
/// transpose, from the frame of the mirror direction to that of the surface.
Vec from_mirror(double theta_in, Vec d) {
    const double c = std::cos(theta_in * kDegree), s = std::sin(theta_in * kDegree);
    return {-c * d.x - s * d.z, -d.y, -s * d.x + c * d.z};
}
Vec to_mirror(double theta_in, Vec v) {
    const double c = std::cos(theta_in * kDegree), s = std::sin(theta_in * kDegree);
    return {-c * v.x - s * v.z, -v.y, -s * v.x + c * v.z};
}

std::size_t nearest_wavelength(const std::vector<std::string>& channels, double wanted) {
    std::size_t best = 0;
    double off = INFINITY;
    for (std::size_t c = 0; c < channels.size(); ++c) {
        const double at = std::abs(std::strtod(channels[c].c_str(), nullptr) - wanted);
        if (at < off) {
            off = at;
            best = c;
        }
    }
    return best;
}

}  // namespace

double bezier(double x, double l) {
    // x = 2 (1 - t) t l + t^2 solved for t, without the pole where the curve is a line.
    const double q = 1 - 2 * l;
    const double root = std::sqrt(std::max(0.0, l * l + q * x));
    const double t = l + root > 0 ? x / (l + root) : 0.0;
    return 2 * (1 - t) * t * (1 - l) + t * t;
}

Material::Material(const Component& component, Extrapolation extrapolation, Understood& account)
    : extrapolation_(extrapolation), channels_(component.cloud.channels) {
    const auto index = [&](const char* name) {
        return static_cast<std::size_t>(std::find(channels_.begin(), channels_.end(), name) -
                                        channels_.begin());
    };
    const bool wavelengths = std::all_of(channels_.begin(), channels_.end(),
                                         [](const std::string& c) { return c.ends_with("nm"); });
    xyz_ = index("X") < channels_.size() && index("Y") < channels_.size() &&
           index("Z") < channels_.size();
    if (xyz_)
        pick_ = {index("X"), index("Y"), index("Z")};
    else if (index("R") < channels_.size() && index("G") < channels_.size() &&
             index("B") < channels_.size())
        pick_ = {index("R"), index("G"), index("B")};
    else if (wavelengths && channels_.size() >= 3)
        pick_ = {nearest_wavelength(channels_, 620), nearest_wavelength(channels_, 540),
                 nearest_wavelength(channels_, 460)};
    else if (channels_.size() != 1)
        throw Error("unfit_measurement", "the channels of this file make no colour");
    bool more_azimuths = false;
    for (const Incidence& one : incidences_of(component, usual_theta_in())) {
        if (!lobes_.empty() && lobes_.back().theta_i == one.theta_i) {
            more_azimuths = true;
            continue;
        }
        Hemisphere hemisphere(one, channels_.size());
        if (!hemisphere.has_area()) continue;
        std::vector<double> reach = reach_of(hemisphere);
        lobes_.push_back({one.theta_i, std::move(hemisphere), std::move(reach)});
    }
    if (lobes_.empty())
        throw Error("unfit_measurement", "no incidence has three directions that span an area");
    if (more_azimuths)
        account.leave_out("other azimuths of the light",
                          "tables here are isotropic; the first "
                          "azimuth of each theta_in is taken");
    find_levels();
}

std::vector<double> Material::theta_in() const {
    std::vector<double> list;
    for (const Lobe& lobe : lobes_) list.push_back(lobe.theta_i);
    return list;
}

Colour Material::to_rgb(const double* values) const {
    const Colour c = {values[pick_[0]], values[pick_[1]], values[pick_[2]]};
    if (!xyz_) return c;
    // IEC 61966-2-1, CIE XYZ under D65 to linear sRGB.
    return {3.2406 * c[0] - 1.5372 * c[1] - 0.4986 * c[2],
            -0.9689 * c[0] + 1.8758 * c[1] + 0.0415 * c[2],
            0.0557 * c[0] - 0.2040 * c[1] + 1.0570 * c[2]};
}

Colour Material::lobe_value(const Lobe& lobe, Vec out, Origin& origin) const {
    std::array<double, kChannelsMax> values;
    std::uint32_t hint = Triangulation::kNone;
    if (out.z >= 0 && lobe.hemisphere.value(out, hint, values.data(), origin))
        return to_rgb(values.data());
    const double theta = std::min(theta_of(out), 90.0), phi = phi_of(out);
    const double edge = between_degrees(lobe.reach, phi);
    origin = Origin::kExtrapolated;
    // A hair inside, for the edge is found in steps of half a degree and is no circle.
    bool found = false;
    for (double back = 0; back <= 4 && !found; back += 0.25) {
        Origin ignored{};
        found = lobe.hemisphere.value(direction(std::max(0.0, std::min(theta, edge) - back), phi),
                                      hint, values.data(), ignored);
    }
    if (!found) {  // an azimuth that nothing was measured at: the same angle across the plane
        const double other = between_degrees(lobe.reach, -phi);
        Origin ignored{};
        found = lobe.hemisphere.value(direction(std::max(0.0, std::min(theta, other) - 0.5), -phi),
                                      hint, values.data(), ignored);
    }
    if (!found) return {0, 0, 0};
    const double width = 90 - edge;
    const double place = width > 0 ? std::clamp((theta - edge) / width, 0.0, 1.0) : 1.0;
    const double a = bezier(place, extrapolation_.l);
    Colour c = to_rgb(values.data());
    for (double& v : c) v *= (1 - a) + a * extrapolation_.p;
    return c;
}

Colour Material::aligned_value(double theta_in, Vec out, Origin& origin) const {
    const Vec about = to_mirror(theta_in, out);
    const auto above = std::upper_bound(lobes_.begin(), lobes_.end(), theta_in,
                                        [](double t, const Lobe& l) { return t < l.theta_i; });
    const auto at = [&](const Lobe& lobe, Origin& from) {
        return lobe_value(lobe, from_mirror(lobe.theta_i, about), from);
    };
    if (above == lobes_.begin()) return at(lobes_.front(), origin);
    const Lobe& low = *(above - 1);
    if (above == lobes_.end() || low.theta_i == theta_in) {
        const Colour c = at(low, origin);
        if (theta_in > low.theta_i) origin = Origin::kExtrapolated;
        return c;
    }
    Origin first{}, second{};
    const Colour a = at(low, first), b = at(*above, second);
    const double share = (theta_in - low.theta_i) / (above->theta_i - low.theta_i);
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
    // Rings about the mirror direction, dense at its peak: radial = 180 (i / n)^2 degrees.
    constexpr int kRings = 160, kSpokes = 144;
    Albedo sum;
    double beyond = 0;
    for (int ring = 0; ring < kRings; ++ring) {
        const double u = (ring + 0.5) / kRings;
        const double radial = std::numbers::pi * u * u;
        const double width = std::numbers::pi * 2 * u / kRings;
        for (int spoke = 0; spoke < kSpokes; ++spoke) {
            const double azimuth = 360.0 * (spoke + 0.5) / kSpokes;
            const Vec out = from_mirror(theta_in, direction(radial / kDegree, azimuth));
            if (out.z <= 0) continue;
            Origin origin{};
            const Colour f = value(theta_in, out, origin);
            const double weight = std::sin(radial) * width * 2 * std::numbers::pi / kSpokes * out.z;
            for (std::size_t k = 0; k < 3; ++k) sum.value[k] += weight * std::max(0.0, f[k]);
            if (origin == Origin::kExtrapolated) beyond += weight * std::max(0.0, f[1]);
        }
    }
    sum.extrapolated = sum.value[1] > 0 ? beyond / sum.value[1] : 0;
    return sum;
}

Material::Albedo Material::average_albedo() const {
    // Midpoints in mu^2, in which 2 mu d mu is uniform.
    constexpr int kAngles = 24;
    Albedo mean;
    double beyond = 0;
    for (int n = 0; n < kAngles; ++n) {
        const double mu = std::sqrt((n + 0.5) / kAngles);
        const Albedo one = albedo(std::acos(mu) / kDegree);
        for (std::size_t k = 0; k < 3; ++k) mean.value[k] += one.value[k] / kAngles;
        beyond += one.extrapolated * one.value[1] / kAngles;
    }
    mean.extrapolated = mean.value[1] > 0 ? beyond / mean.value[1] : 0;
    return mean;
}

}  // namespace kiln::measured
