// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "tests/reference/ggx_lambert.h"
#include "tests/reference/microfacet_models.h"

namespace kiln::reference {
namespace {

constexpr int kMostBounces = 100000;

struct Vector {
    double x, y, z;
};

Vector unit(const Vector& v) {
    const double length = std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
    return {v.x / length, v.y / length, v.z / length};
}

/// In (0, 1): a walk takes logarithms of it.
double uniform(std::mt19937_64& random) {
    return (static_cast<double>(random() >> 11) + 0.5) * 0x1p-53;
}

/// Cosine-distributed about a unit vector: a unit sphere that touches the origin (Nusselt).
Vector cosine_about(const Vector& n, std::mt19937_64& random) {
    const double z = 2 * uniform(random) - 1, phi = 2 * std::numbers::pi * uniform(random);
    const double s = std::sqrt((1 - z) * (1 + z));
    return unit({n.x + s * std::cos(phi), n.y + s * std::sin(phi), n.z + z});
}

/// A normal as seen from w (of the whole sphere). GGX normals are those of a half-sphere, stretched
/// (Walter, Dong, Marschner, Greenberg 2015): of the full sphere as seen from the stretched w, the
/// normals that look up. One of 2 / (1 + w.z) tries is kept.
Vector visible_normal(double alpha, const Vector& w, std::mt19937_64& random) {
    const Vector stretched = unit({alpha * w.x, alpha * w.y, w.z});
    Vector m = cosine_about(stretched, random);
    while (m.z <= 0) m = cosine_about(stretched, random);
    return unit({alpha * m.x, alpha * m.y, m.z});
}

WalkedAlbedo gather(double alpha, double rho, int walks, std::uint64_t seed, bool all_views,
                    double NoV) {
    std::mt19937_64 random(seed);
    double sum = 0, squares = 0, single = 0;
    for (int i = 0; i < walks; ++i) {
        // A cosine-distributed view has NoV^2 uniform.
        const double view = all_views ? std::max(1e-4, std::sqrt(uniform(random))) : NoV;
        const int bounces = ggx_lambert_walk(alpha, view, random).bounces;
        const double left = std::pow(rho, bounces);
        sum += left;
        squares += left * left;
        single += bounces == 1 ? 1 : 0;
    }
    const double n = walks, mean = sum / n, share = single / n;
    return {{mean, std::sqrt(std::max(0.0, squares / n - mean * mean) / n)},
            {rho * share, rho * std::sqrt(share * (1 - share) / n)}};
}

}  // namespace

Walk ggx_lambert_walk(double alpha, double NoV, std::mt19937_64& random) {
    if (!(alpha >= 1e-3 && alpha <= 1 && NoV >= 1e-4 && NoV <= 1))
        throw std::domain_error("reference: alpha or NoV outside [1e-3, 1] x [1e-4, 1]");
    Vector ray{-std::sqrt((1 - NoV) * (1 + NoV)), 0, -NoV};
    double below = 1;  // C1: the share of the surface that lies lower than the ray
    for (int bounces = 0; bounces < kMostBounces; ++bounces) {
        // Free flight, Heitz et al. 2016, section 4: upwards a ray passes with probability
        // C1^Lambda, downwards Lambda counts as -1 - Lambda.
        const double u = uniform(random);
        const double lambda = smith_lambda(Distribution::ggx, alpha, std::abs(ray.z));
        if (ray.z > 0) {
            if (u < std::pow(below, lambda)) return {bounces, ray.z};
            below /= std::pow(u, 1 / lambda);
        } else {
            below *= std::pow(u, 1 / (1 + lambda));
        }
        const Vector normal = visible_normal(alpha, {-ray.x, -ray.y, -ray.z}, random);
        ray = cosine_about(normal, random);
    }
    throw std::runtime_error("reference: a walk does not leave the surface");
}

WalkedAlbedo ggx_lambert_walked_albedo(double alpha, double NoV, double rho, int walks,
                                       std::uint64_t seed) {
    return gather(alpha, rho, walks, seed, false, NoV);
}

WalkedAlbedo ggx_lambert_walked_average(double alpha, double rho, int walks, std::uint64_t seed) {
    return gather(alpha, rho, walks, seed, true, 1);
}

}  // namespace kiln::reference
