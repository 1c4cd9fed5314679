// SPDX-License-Identifier: Apache-2.0
#include "server/study/facet_walks.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "server/base/error.h"

// Heitz, Hanika, d'Eon, Dachsbacher 2016, "Multiple-Scattering Microfacet BSDFs with the Smith
// Model", section 4 for the heights, section 5.3 for the connection with L at each facet.
namespace kiln {

namespace {

/// Ends what cannot happen: each facet lets go of a third of the light and more (ggx_lambert.h).
constexpr int kFacetsMax = 10000;

double sine(double cosine) { return std::sqrt((1 - cosine) * (1 + cosine)); }

}  // namespace

FacetWalks::FacetWalks(double alpha, double albedo, std::uint64_t seed)
    : alpha_(alpha), albedo_(albedo), random_(seed) {}

WalkedValue FacetWalks::value(const Directions& d, int walks) {
    const Vector view{sine(d.NoV), 0, d.NoV};
    const double sinL = sine(d.NoL);
    const Vector light{sinL * d.cos_phi, sinL * sine(d.cos_phi), d.NoL};
    double mean = 0, spread = 0;
    for (int i = 1; i <= walks; ++i) {
        const double value = walk(view, light), off = value - mean;
        mean += off / i;
        spread += off * (value - mean);
    }
    return {mean, std::sqrt(spread / (static_cast<double>(walks) * (walks - 1)))};
}

/// In (0, 1): a walk takes logarithms of it.
double FacetWalks::uniform() { return (static_cast<double>(random_() >> 11) + 0.5) * 0x1p-53; }

/// Lambda of the cosine's size, Heitz 2014, eq. 72.
double FacetWalks::reach(double cosine) const {
    const double slope = alpha_ * sine(cosine);
    return 0.5 * (std::sqrt(cosine * cosine + slope * slope) / std::abs(cosine) - 1);
}

/// Sum over the facets of one walk of what each sends towards L and out, over NoL.
double FacetWalks::walk(const Vector& view, const Vector& light) {
    const double light_reach = reach(light.z);
    Vector ray{-view.x, -view.y, -view.z};
    double below = 1;  // C1 of the height: the part of the surface that lies lower
    double throughput = 1, sum = 0;
    for (int facet = 0; throughput > 0; ++facet) {
        if (facet == kFacetsMax)
            throw Error("internal", "a walk over facets does not leave the surface");
        const double u = uniform(), lambda = reach(ray.z);
        if (ray.z > 0) {
            if (u < std::pow(below, lambda)) break;
            below /= std::pow(u, 1 / lambda);
        } else {
            below *= std::pow(u, 1 / (1 + lambda));
        }
        const Vector m = normal({-ray.x, -ray.y, -ray.z});
        throughput *= albedo_;
        const double towards = m.x * light.x + m.y * light.y + m.z * light.z;
        // The first facet's height is integrated: G2 / G1(V).
        const double out =
            facet == 0 ? (1 + lambda) / (1 + lambda + light_reach) : std::pow(below, light_reach);
        sum += throughput * std::max(0.0, towards) / std::numbers::pi * out;
        ray = about(m);
    }
    return sum / light.z;
}

/// Visible normals by spherical caps (Dupuy, Benyoub 2023), of a view of the whole sphere.
FacetWalks::Vector FacetWalks::normal(const Vector& seen_from) {
    const double x = alpha_ * seen_from.x, y = alpha_ * seen_from.y, z = seen_from.z;
    const double length = std::sqrt(x * x + y * y + z * z);
    const double vz = z / length, phi = 2 * std::numbers::pi * uniform();
    const double cz = std::clamp((1 - uniform()) * (1 + vz) - vz, -1.0, 1.0), s = sine(cz);
    const Vector h{alpha_ * (s * std::cos(phi) + x / length),
                   alpha_ * (s * std::sin(phi) + y / length), std::max(0.0, cz + vz)};
    const double size = std::sqrt(h.x * h.x + h.y * h.y + h.z * h.z);
    if (!(size > 0)) return {0, 0, 1};
    return {h.x / size, h.y / size, h.z / size};
}

/// A cosine lobe: a unit sphere that touches the plane (Nusselt).
FacetWalks::Vector FacetWalks::about(const Vector& normal) {
    const double z = 2 * uniform() - 1, phi = 2 * std::numbers::pi * uniform(), s = sine(z);
    const Vector v{normal.x + s * std::cos(phi), normal.y + s * std::sin(phi), normal.z + z};
    const double size = std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
    if (!(size > 0)) return normal;
    return {v.x / size, v.y / size, v.z / size};
}

}  // namespace kiln
