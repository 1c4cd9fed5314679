// SPDX-License-Identifier: Apache-2.0
#include "server/measured/physics.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace kiln::measured {
namespace {

double largest(const Material::Albedo& e) {
    return *std::max_element(e.value.begin(), e.value.end());
}

/// Light and view by a lattice of rank 1 in (sin^2 theta_i, sin^2 theta_o, azimuth): the generators
/// are powers of the plastic number's analogue of three dimensions (Roberts 2018).
struct Pairs {
    std::vector<double> theta_in, theta_in_back;
    std::vector<Vec> out, out_back;
};
Pairs pairs(std::size_t count) {
    Pairs made;
    constexpr double kG = 1.2207440846057596;  // g^4 = g + 1
    for (std::size_t n = 0; n < count; ++n) {
        const auto part = [&](double step) {
            const double at = 0.5 + step * static_cast<double>(n + 1);
            return at - std::floor(at);
        };
        const double in = std::asin(std::sqrt(part(1 / kG))) / kDegree;
        const double out = std::asin(std::sqrt(part(1 / (kG * kG)))) / kDegree;
        const double phi = 360 * part(1 / (kG * kG * kG));
        made.theta_in.push_back(in);
        made.out.push_back(direction(out, phi));
        made.theta_in_back.push_back(out);
        made.out_back.push_back(direction(in, -phi));
    }
    return made;
}

Reciprocity judged(std::vector<double>& relative, double off, double all) {
    Reciprocity found;
    if (relative.empty()) return found;
    std::sort(relative.begin(), relative.end());
    found.l1 = all > 0 ? off / all : 0;
    found.median = relative[relative.size() / 2];
    found.p95 = relative[relative.size() * 95 / 100];
    return found;
}

void judge_reciprocity(const LobeTables& tables, Resampler& resampler, Physics& physics) {
    constexpr std::size_t kPairs = 16384;
    const Pairs set = pairs(kPairs);
    const Sampled there = resampler.values(tables, set.theta_in, set.out);
    const Sampled back = resampler.values(tables, set.theta_in_back, set.out_back);
    std::vector<double> all, measured;
    double off[2] = {}, sum[2] = {};
    for (std::size_t n = 0; n < kPairs; ++n) {
        const double x = static_cast<double>(there.r[n]) + there.g[n] + there.b[n];
        const double y = static_cast<double>(back.r[n]) + back.g[n] + back.b[n];
        const double mean = 0.5 * (std::abs(x) + std::abs(y));
        const double relative = mean > 0 ? std::abs(x - y) / mean : 0.0;
        const bool both = there.origin[n] < 1.5f && back.origin[n] < 1.5f;
        for (const bool part : {false, true}) {
            if (part && !both) continue;
            (part ? measured : all).push_back(relative);
            off[part] += std::abs(x - y);
            sum[part] += mean;
        }
    }
    physics.measured_pairs = static_cast<double>(measured.size()) / kPairs;
    physics.all = judged(all, off[0], sum[0]);
    physics.measured = judged(measured, off[1], sum[1]);
}

/// Steps that go into 90 degrees evenly, and the measured incidences, where E has its kinks.
std::vector<double> degrees(double step, const LobeTables& tables) {
    constexpr double kSame = 1e-3;
    std::vector<double> list;
    for (double theta = 0; theta <= 90; theta += step) list.push_back(theta);
    for (const std::size_t lobe : tables.measured) {
        const double theta = tables.theta_in[lobe];
        const auto above = std::lower_bound(list.begin(), list.end(), theta - kSame);
        if (above == list.end() || *above > theta + kSame) list.insert(above, theta);
    }
    return list;
}

/// The most of what was found within less than a degree of each whole one: the scale between two
/// degrees is made of both.
std::vector<double> most_by_degree(const std::vector<double>& theta_in,
                                   const std::vector<Material::Albedo>& found) {
    std::vector<double> most(91, 0.0);
    for (std::size_t n = 0; n < theta_in.size(); ++n)
        for (const double at : {std::floor(theta_in[n]), std::ceil(theta_in[n])}) {
            double& e = most[static_cast<std::size_t>(std::min(at, 90.0))];
            e = std::max(e, largest(found[n]));
        }
    return most;
}

}  // namespace

Companion companion_of(const LobeTables& tables, std::size_t width, Resampler& resampler) {
    std::vector<double> theta_in;
    for (std::size_t x = 0; x < width; ++x)
        theta_in.push_back(std::acos((static_cast<double>(x) + 0.5) / static_cast<double>(width)) /
                           kDegree);
    const std::vector<Material::Albedo> found = resampler.albedos(tables, theta_in);
    Companion companion;
    companion.table = {width, 1, {"R", "G", "B", "extrapolated"}, {}};
    companion.table.planes.resize(4);
    for (const Material::Albedo& e : found) {
        for (std::size_t k = 0; k < 3; ++k)
            companion.table.planes[k].push_back(static_cast<float>(e.value[k]));
        companion.table.planes[3].push_back(static_cast<float>(e.extrapolated));
    }
    companion.average = resampler.average_albedo(tables);
    return companion;
}

Physics physics_of(const LobeTables& tables, Resampler& resampler) {
    Physics physics;
    physics.theta_in = degrees(5, tables);
    physics.albedo = resampler.albedos(tables, physics.theta_in);
    for (std::size_t n = 0; n < physics.albedo.size(); ++n)
        if (largest(physics.albedo[n]) > physics.albedo_max) {
            physics.albedo_max = largest(physics.albedo[n]);
            physics.albedo_max_theta_in = physics.theta_in[n];
        }
    physics.extrapolated = resampler.average_albedo(tables).extrapolated;
    judge_reciprocity(tables, resampler, physics);
    return physics;
}

std::vector<double> conserve(LobeTables& tables, Resampler& resampler) {
    const std::vector<double> theta_in = degrees(1, tables);
    std::vector<double> scale(kMeasuredCurve, 1.0);
    tables.make_symmetric(scale);
    // Towards s E = 1 where light would be made, from both sides; the last rounds only darken, and
    // darkening one angle lowers the albedo of all.
    constexpr int kRounds = 12, kDarkening = 2;
    constexpr AlbedoRule kRough = {48, 64};
    for (int round = 0; round < kRounds; ++round) {
        const bool last = round >= kRounds - kDarkening;
        const auto found = resampler.albedos(tables, theta_in, last ? AlbedoRule{} : kRough);
        const std::vector<double> most = most_by_degree(theta_in, found);
        bool conserves = true;
        for (std::size_t n = 0; n < most.size(); ++n) {
            const double e = most[n];
            conserves = conserves && e <= 1 && scale[n] >= 1;
            // Half a step each, for the light's scale and the view's both count.
            const double step = last ? std::max(1.0, e) : std::sqrt(e);
            if (e > 0) scale[n] = std::min(1.0, scale[n] / step);
        }
        scale.back() = scale[most.size() - 1];
        tables.make_symmetric(scale);
        if (conserves && !last) round = kRounds - kDarkening - 1;
    }
    return scale;
}

}  // namespace kiln::measured
