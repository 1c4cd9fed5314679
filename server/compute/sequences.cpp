// SPDX-License-Identifier: Apache-2.0
#include "server/compute/sequences.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace kiln {

namespace {

constexpr double kTwo32 = 4294967296.0;

double fraction(double x) { return x - std::floor(x); }

/// The middle of the 2^-32 wide cell: never 0 and never 1.
double unit_from_bits(std::uint32_t bits) { return (bits + 0.5) / kTwo32; }

/// SplitMix64's finaliser (Steele, Lea, Flood 2014).
std::uint64_t mix(std::uint64_t x) {
    x += 0x9E3779B97F4A7C15u;
    x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9u;
    x = (x ^ (x >> 27)) * 0x94D049BB133111EBu;
    return x ^ (x >> 31);
}

std::uint64_t key(std::uint64_t seed, std::uint64_t replicate, std::uint64_t dimension) {
    return mix(mix(mix(seed) ^ replicate) ^ dimension);
}

std::uint32_t reverse_bits(std::uint32_t x) {
    x = (x >> 16) | (x << 16);
    x = ((x & 0x00FF00FFu) << 8) | ((x & 0xFF00FF00u) >> 8);
    x = ((x & 0x0F0F0F0Fu) << 4) | ((x & 0xF0F0F0F0u) >> 4);
    x = ((x & 0x33333333u) << 2) | ((x & 0xCCCCCCCCu) >> 2);
    return ((x & 0x55555555u) << 1) | ((x & 0xAAAAAAAAu) >> 1);
}

/// Nested uniform scrambling by hashing (Laine, Karras 2011, in the form of Burley 2020, listing
/// 2).
std::uint32_t owen_scramble(std::uint32_t bits, std::uint32_t seed) {
    std::uint32_t x = reverse_bits(bits);
    x += seed;
    x ^= x * 0x6C50B47Cu;
    x ^= x * 0xB82F1E52u;
    x ^= x * 0xC7AFE638u;
    x ^= x * 0x8D22F6E6u;
    return reverse_bits(x);
}

using Directions = std::array<std::uint32_t, 32>;

/// Whether x generates all 2^degree - 1 powers modulo this polynomial over two elements.
bool is_primitive(std::uint32_t polynomial, unsigned degree) {
    const std::uint32_t full = (1u << degree) - 1;
    std::uint32_t power = 1, order = 0;
    do {
        power <<= 1;
        if (power >> degree & 1) power ^= polynomial;
        ++order;
    } while (power != 1 && order < full);
    return order == full;
}

/// Direction numbers of Sobol dimensions: the first is van der Corput's, then one a primitive
/// polynomial in their order (Sobol 1967; the recurrence of Bratley, Fox 1988). Which odd numbers
/// start the recurrence is free: the first three dimensions have Joe's and Kuo's (2008), the others
/// what a hash says.
std::array<Directions, kDimensionsMax> sobol_directions() {
    std::array<Directions, kDimensionsMax> v{};
    for (unsigned i = 0; i < 32; ++i) v[0][i] = 1u << (31 - i);
    std::size_t dimension = 1;
    for (std::uint32_t polynomial = 3; dimension < kDimensionsMax; polynomial += 2) {
        const auto degree = static_cast<unsigned>(std::bit_width(polynomial)) - 1;
        if (!is_primitive(polynomial, degree)) continue;
        Directions& of = v[dimension];
        for (unsigned i = 0; i < degree; ++i) {
            const std::uint64_t free = dimension < 3 ? 3 : mix(64 * dimension + i) >> 32;
            const auto odd = static_cast<std::uint32_t>(free | 1) & ((2u << i) - 1);
            of[i] = odd << (31 - i);
        }
        for (unsigned i = degree; i < 32; ++i) {
            of[i] = of[i - degree] ^ (of[i - degree] >> degree);
            for (unsigned k = 1; k < degree; ++k)
                if (polynomial >> (degree - k) & 1) of[i] ^= of[i - k];
        }
        ++dimension;
    }
    return v;
}

double radical_inverse(std::uint32_t i, std::uint32_t base) {
    double result = 0, scale = 1.0 / base;
    for (; i != 0; i /= base, scale /= base) result += (i % base) * scale;
    return result;
}

constexpr std::array<int, kDimensionsMax> kPrimes = {2,  3,  5,  7,  11, 13, 17, 19,
                                                     23, 29, 31, 37, 41, 43, 47, 53};

}  // namespace

Sequence::Sequence(Sampler sampler, std::size_t dimensions, std::size_t first_dimension,
                   std::uint64_t seed, std::uint32_t replicate, std::uint32_t size)
    : sampler_(sampler), size_(size), dimensions_(dimensions) {
    for (std::size_t d = 0; d < dimensions_; ++d) {
        key_[d] = key(seed, replicate, first_dimension + d);
        shift_[d] = unit_from_bits(static_cast<std::uint32_t>(key_[d] >> 32));
    }
}

UniformPoint Sequence::operator()(std::uint32_t i) const {
    switch (sampler_) {
        case Sampler::hammersley:
            return shifted(halton(i));
        case Sampler::lattice:
            return shifted(pairs_within_batches() ? halton(i) : lattice(i));
        case Sampler::sobol_owen:
            return sobol(i);
        case Sampler::random:
            return random(i);
    }
    __builtin_unreachable();
}

/// A walk pairs the points of a batch with each other (walk_row() of kernels/ggx_lambert.h), so
/// that every batch has to be even in every dimension. i / n is all but the same within one,
/// and of a rank-1 lattice in 16 dimensions a thousand points are so far from even that the
/// error stalls at 2e-4.
bool Sequence::pairs_within_batches() const { return dimensions_ > kDimensions; }

UniformPoint Sequence::halton(std::uint32_t i) const {
    UniformPoint point{(i + 0.5) / size_};
    for (std::size_t d = 1; d < dimensions_; ++d)
        point[d] = radical_inverse(i, static_cast<std::uint32_t>(kPrimes[d - 1]));
    if (pairs_within_batches())
        point[0] = radical_inverse(i, static_cast<std::uint32_t>(kPrimes[dimensions_ - 1]));
    return point;
}

/// Rank-1 in i / n, with the plastic number's powers in the other dimensions (Roberts 2018):
/// even for every n, where a tabulated generator serves one.
UniformPoint Sequence::lattice(std::uint32_t i) const {
    constexpr double kGolden = 0.6180339887498949;
    constexpr double kPlastic = 0.7548776662466927;
    return {(i + 0.5) / size_, fraction(i * kGolden), fraction(i * kPlastic)};
}

UniformPoint Sequence::sobol(std::uint32_t i) const {
    static const auto directions = sobol_directions();
    UniformPoint point{};
    for (std::size_t d = 0; d < dimensions_; ++d) {
        std::uint32_t bits = 0;
        for (std::uint32_t rest = i, bit = 0; rest != 0; rest >>= 1, ++bit)
            if (rest & 1) bits ^= directions[d][bit];
        point[d] = unit_from_bits(owen_scramble(bits, static_cast<std::uint32_t>(key_[d])));
    }
    return point;
}

UniformPoint Sequence::random(std::uint32_t i) const {
    UniformPoint point{};
    for (std::size_t d = 0; d < dimensions_; ++d)
        point[d] = unit_from_bits(static_cast<std::uint32_t>(mix(key_[d] + i) >> 32));
    return point;
}

/// Cranley, Patterson 1976: a random shift on the torus, kept off 0.
UniformPoint Sequence::shifted(UniformPoint point) const {
    for (std::size_t d = 0; d < dimensions_; ++d)
        point[d] = std::max(fraction(point[d] + shift_[d]), 0.5 / kTwo32);
    // Both halves of the azimuth serve the same integrand. A set that is shifted on a torus
    // wants it periodic, so it goes round once; a net loses a fifth of its accuracy when it is
    // folded in two.
    const bool walk = pairs_within_batches();
    for (std::size_t d = walk ? 1 : 0; d + 1 < dimensions_; d += kWalkDimensions)
        point[d] = point[d] < 0.5 ? 2 * point[d] : 2 - 2 * point[d];
    return point;
}

}  // namespace kiln
