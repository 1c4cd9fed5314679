// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>

// E by visible normals on scrambled Sobol points, written a second time in textbook form: vectors,
// trigonometry, Smith's Λ, digits flipped one by one. Shares no line with kernels/ or points.cpp,
// so that what both find of an error's size and slope belongs to the integrand and the method.
namespace kiln::plain_albedo {

inline std::uint64_t hash(std::uint64_t x) {
    x = (x ^ (x >> 33)) * 0xFF51AFD7ED558CCDu;  // MurmurHash3's finaliser (Appleby 2011)
    x = (x ^ (x >> 33)) * 0xC4CEB9FE1A85EC53u;
    return x ^ (x >> 33);
}

/// Owen 1995: each of the first 30 digits is flipped or not by a coin of its own for every prefix.
inline double nested_uniform(std::uint32_t bits, std::uint64_t key) {
    std::uint32_t flipped = 0;
    for (int digit = 0; digit < 30; ++digit) {
        const std::uint64_t prefix = digit == 0 ? 0 : bits >> (32 - digit);
        const std::uint64_t node = (std::uint64_t{1} << digit) + prefix;
        flipped |= (static_cast<std::uint32_t>(hash(key ^ hash(node))) & 1u) << (31 - digit);
    }
    return (static_cast<double>((bits ^ flipped) >> 2) + 0.5) / 1073741824.0;
}

/// The first two dimensions of Sobol: van der Corput, and the one whose generator matrix is
/// Pascal's triangle modulo two.
inline std::array<std::uint32_t, 2> sobol(std::uint32_t i) {
    std::array<std::uint32_t, 2> x{};
    for (std::uint32_t column = 0, v = 1u << 31; column < 32; ++column, v ^= v >> 1)
        if (i >> column & 1) {
            x[0] ^= 1u << (31 - column);
            x[1] ^= v;
        }
    return x;
}

inline double smith_lambda(double cosine, double alpha) {
    const double tangent2 = (1 - cosine * cosine) / (cosine * cosine);
    return (std::sqrt(1 + alpha * alpha * tangent2) - 1) / 2;
}

/// One replicate of N points: the mean of G2 / G1, height-correlated (Heitz 2014, eq. 99). Normals
/// by spherical caps (Dupuy, Benyoub 2023), azimuths over half a turn.
inline double replicate(double NoV, double alpha, std::uint32_t points, std::uint64_t seed) {
    const double sine = std::sqrt(1 - NoV * NoV);
    const double length = std::hypot(alpha * sine, NoV);
    const double stretched[3] = {alpha * sine / length, 0, NoV / length};
    const double view = smith_lambda(NoV, alpha);
    double sum = 0;
    for (std::uint32_t i = 0; i < points; ++i) {
        const auto digits = sobol(i);
        const double phi = std::numbers::pi * nested_uniform(digits[0], hash(2 * seed + 1));
        const double z = 1 - nested_uniform(digits[1], hash(2 * seed + 2)) * (1 + stretched[2]);
        const double r = std::sqrt(std::fmax(0, (1 - z) * (1 + z)));
        const double h[3] = {alpha * (r * std::cos(phi) + stretched[0]), alpha * r * std::sin(phi),
                             z + stretched[2]};
        const double norm = std::sqrt(h[0] * h[0] + h[1] * h[1] + h[2] * h[2]);
        const double VoH = (sine * h[0] + NoV * h[2]) / norm;
        const double NoL = 2 * VoH * h[2] / norm - NoV;
        if (NoL > 0) sum += (1 + view) / (1 + view + smith_lambda(NoL, alpha));
    }
    return sum / points;
}

}  // namespace kiln::plain_albedo
