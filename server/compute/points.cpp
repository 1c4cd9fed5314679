// SPDX-License-Identifier: Apache-2.0
#include "server/compute/points.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "server/compute/one_lane.h"
#include "server/compute/terms.h"

namespace kiln {

namespace {

// The host's names for what the kernels number (terms.h, points.h, job_spec.h).
static_assert(1 << kWeight == KILN_TERM_WEIGHT && 1 << kSchlick == KILN_TERM_FRESNEL &&
              1 << kDeficit == KILN_TERM_DEFICIT && 1 << kColour == KILN_TERM_COLOUR &&
              1 << kDiffuse == KILN_TERM_DIFFUSE && 1 << kTransmitted == KILN_TERM_TRANSMITTED &&
              kTermCount == KILN_TERM_COUNT);
static_assert(kAlbedoParameter == KILN_PARAMETER_ALBEDO &&
              kExponentParameter == KILN_PARAMETER_EXPONENT &&
              kParameterCount == KILN_PARAMETER_COUNT && kPointScalars == KILN_POINT_SCALARS &&
              kWalkScalars == KILN_WALK_SCALARS);
static_assert(kLogTangents == KILN_IMPORTANCE_LOG_TANGENTS &&
              kVisibleLights == KILN_IMPORTANCE_VISIBLE_LIGHTS &&
              kPartedLights == KILN_IMPORTANCE_PARTED_LIGHTS &&
              kHorizonNormals == KILN_IMPORTANCE_HORIZON_NORMALS &&
              kCharlieSoftened == KILN_MASKING_CHARLIE_SOFTENED);

constexpr double kTwo32 = 4294967296.0;
// Azimuth and polar angle of each direction, before them the inclination of a walk's facet, then
// NoV of averages. Azimuths are in half turns: the integrand is even in them.
constexpr std::size_t kDimensions = 3, kWalkDimensions = KILN_WALK_FACET_SCALARS,
                      kDimensionsMax = kWalkDimensions * KILN_WALK_ROW_FACETS + 1;
using Point = std::array<double, kDimensionsMax>;

std::size_t dimensions(PointKind kind) {
    return kind == PointKind::facet_walk ? kDimensionsMax : kDimensions;
}

/// Where a kind's dimensions start among those of a job: sets that meet in one channel share none.
std::size_t first_dimension(PointKind kind) {
    if (kind == PointKind::facet_walk) return 2 * kDimensions;
    return kind == PointKind::cosine_diffuse || kind == PointKind::parted_lights_diffuse
               ? kDimensions
               : 0;
}

double natural_log(double x) { return one_lane::lane_log2(x) * 0.69314718055994531; }

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

/// Generators of one replicate's points.
class Generator {
  public:
    Generator(Sampler sampler, PointKind kind, std::uint64_t seed, std::uint32_t replicate,
              std::uint32_t size)
        : sampler_(sampler), size_(size), dimensions_(dimensions(kind)) {
        for (std::size_t d = 0; d < dimensions_; ++d) {
            key_[d] = key(seed, replicate, first_dimension(kind) + d);
            shift_[d] = unit_from_bits(static_cast<std::uint32_t>(key_[d] >> 32));
        }
    }

    Point operator()(std::uint32_t i) const {
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

  private:
    /// A walk pairs the points of a batch with each other (walk_row() of kernels/ggx_lambert.h), so
    /// that every batch has to be even in every dimension. i / n is all but the same within one,
    /// and of a rank-1 lattice in 16 dimensions a thousand points are so far from even that the
    /// error stalls at 2e-4.
    bool pairs_within_batches() const { return dimensions_ > kDimensions; }

    Point halton(std::uint32_t i) const {
        Point point{(i + 0.5) / size_};
        for (std::size_t d = 1; d < dimensions_; ++d)
            point[d] = radical_inverse(i, static_cast<std::uint32_t>(kPrimes[d - 1]));
        if (pairs_within_batches())
            point[0] = radical_inverse(i, static_cast<std::uint32_t>(kPrimes[dimensions_ - 1]));
        return point;
    }

    /// Rank-1 in i / n, with the plastic number's powers in the other dimensions (Roberts 2018):
    /// even for every n, where a tabulated generator serves one.
    Point lattice(std::uint32_t i) const {
        constexpr double kGolden = 0.6180339887498949;
        constexpr double kPlastic = 0.7548776662466927;
        return {(i + 0.5) / size_, fraction(i * kGolden), fraction(i * kPlastic)};
    }

    Point sobol(std::uint32_t i) const {
        static const auto directions = sobol_directions();
        Point point{};
        for (std::size_t d = 0; d < dimensions_; ++d) {
            std::uint32_t bits = 0;
            for (std::uint32_t rest = i, bit = 0; rest != 0; rest >>= 1, ++bit)
                if (rest & 1) bits ^= directions[d][bit];
            point[d] = unit_from_bits(owen_scramble(bits, static_cast<std::uint32_t>(key_[d])));
        }
        return point;
    }

    Point random(std::uint32_t i) const {
        Point point{};
        for (std::size_t d = 0; d < dimensions_; ++d)
            point[d] = unit_from_bits(static_cast<std::uint32_t>(mix(key_[d] + i) >> 32));
        return point;
    }

    /// Cranley, Patterson 1976: a random shift on the torus, kept off 0.
    Point shifted(Point point) const {
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

    static constexpr std::array<int, kDimensionsMax> kPrimes = {2,  3,  5,  7,  11, 13, 17, 19,
                                                                23, 29, 31, 37, 41, 43, 47, 53};
    Sampler sampler_;
    std::uint32_t size_;
    std::size_t dimensions_;
    std::array<std::uint64_t, kDimensionsMax> key_{};
    Point shift_{};
};

/// v = V u − ln(1 − u⁸), so that e^V covers what tan θ = α sinh v has to span and the last eighth
/// reaches on to infinity, where the integrand falls like 1 / tan θ: no tail is cut off. The third
/// scalar is the density of all normals over this one, over NoH: 2 sinh v / cosh² v dv / du.
void append_log_tangent(std::vector<double>& values, double cosine, double u) {
    constexpr double kSpan = 16.8;  // tan θ of 10 at α = 1e-6
    const double u2 = u * u, u4 = u2 * u2;
    const double left = (1 - u) * (1 + u) * (1 + u2) * (1 + u4);
    const double e = one_lane::lane_exp(kSpan * u) / left, divisor = 1 / (e * e + 1);
    const double tanh = (e - 1) * (e + 1) * divisor, inverse_cosh = 2 * e * divisor;
    const double slope = kSpan + 8 * u4 * u2 * u / left;
    values.insert(values.end(), {tanh * cosine, inverse_cosh, 2 * tanh * inverse_cosh * slope});
}

/// kernels/horizon_normals.h: all normals of a quarter of the even u, the wide ones of the rest.
/// 2 NoV times the deficit is even over ln NoV, nearly, from NoV ~ α on: NoV = v⁴.
void append_horizon_normal(std::vector<double>& values, double cosine, double u, double v) {
    const bool own = u < 0.25;
    const double rest = own ? 1 - 4 * u : (1 - u) / 0.75;
    const double c = own ? std::sqrt(rest) : rest, s2 = own ? 4 * u : (1 - rest) * (1 + rest);
    const double v3 = v * v * v, NoV = v3 * v;
    values.insert(values.end(),
                  {std::sqrt(s2) * cosine, c, 8 * NoV * v3 / c, s2, own ? 1.0 : 0.0, NoV});
}

/// One facet of a walk after the other, and NoV = √u of an average: KILN_WALK_SCALARS.
void append_walk(std::vector<double>& values, const Point& point) {
    for (std::size_t d = 0; d + 1 < kDimensionsMax; d += kWalkDimensions) {
        // An even disc: √v cos ψ along lines that reach √(1 − v sin² ψ) to either side.
        const double v = point[d + 2], cosine = cos_turn(point[d + 1] / 2);
        const double x = std::sqrt(v) * cosine,
                     reach = std::sqrt(1 - v * (1 - cosine) * (1 + cosine));
        values.insert(values.end(), {point[d], (reach - x) / 2, (reach + x) / 2});
    }
    values.push_back(std::sqrt(point[kDimensionsMax - 1]));
}

/// The sampler's three scalars; the square of the second and u (1 − u); the NoV of an average, √u,
/// which is ∫ 2 NoV dNoV uniformly.
void append(std::vector<double>& values, PointKind kind, const Point& point) {
    const double u = point[1], rest = 1 - u, cosine = cos_turn(point[0] / 2);
    const double NoV = std::sqrt(point[2]);
    switch (kind) {
        case PointKind::visible_normals: {
            const auto whole = visible_normal_point(cosine, u, NoV);
            values.insert(values.end(), whole.begin(), whole.end());
            return;
        }
        case PointKind::ggx_normals: {
            const double z = std::sqrt(rest);
            values.insert(values.end(), {std::sqrt(u) * cosine, z, 1 / z});
            break;
        }
        case PointKind::beckmann_normals: {
            const double T2 = -natural_log(rest);
            values.insert(values.end(), {std::sqrt(T2) * cosine, 1, T2});
            break;
        }
        case PointKind::cosine:
        case PointKind::cosine_diffuse:
            values.insert(values.end(), {cosine, std::sqrt(rest), std::sqrt(u)});
            break;
        case PointKind::uniform:
            values.insert(values.end(), {cosine, rest, std::sqrt(u * (1 + rest))});
            break;
        case PointKind::visible_lights: {  // kernels/visible_lights.h
            const double even = u * (2 - u);
            values.insert(values.end(),
                          {cosine, std::sqrt(even), 2 * rest, even, rest * rest, NoV});
            return;
        }
        case PointKind::parted_lights:
        case PointKind::parted_lights_diffuse:  // kernels/parted_lights.h
            values.insert(values.end(), {cosine, u * u * (1 + 2 * rest), 6 * u * rest,
                                         rest * rest * (1 + 2 * u), 0, NoV});
            return;
        case PointKind::log_tangents:
            append_log_tangent(values, cosine, u);
            break;
        case PointKind::horizon_normals:
            return append_horizon_normal(values, cosine, u, point[2]);
        case PointKind::facet_walk:
            return append_walk(values, point);
    }
    const double second = values[values.size() - 2];
    values.insert(values.end(), {second * second, u * rest, NoV});
}

/// Where the run of points that starts at `at` ends, if the replicate goes on that far.
std::uint32_t batch_end(std::uint32_t at) {
    if (at >= kBatchPointsMax) return at + kBatchPointsMax;
    std::uint32_t end = kFirstBatchPoints;
    while (end <= at) end *= 2;
    return end;
}

}  // namespace

double cos_turn(double u) {
    // Folded into [0, 1/4] of a turn, then into [0, 1/8] as a cosine or a sine; Taylor to below
    // 1e-17.
    constexpr double kTwoPi = 6.283185307179586;
    double folded = u > 0.5 ? 1 - u : u;
    const bool negative = folded > 0.25;
    if (negative) folded = 0.5 - folded;
    const bool as_sine = folded > 0.125;
    const double x = kTwoPi * (as_sine ? 0.25 - folded : folded), x2 = x * x;
    double sum = 0;
    for (int k = 9; k >= 0; --k) {
        const int order = as_sine ? 2 * k + 1 : 2 * k;
        sum = 1 - sum * x2 / ((order + 1) * (order + 2));
    }
    const double value = as_sine ? sum * x : sum;
    return negative ? -value : value;
}

std::array<double, kPointScalars> visible_normal_point(double cosine, double u, double NoV) {
    const double rest = 1 - u;
    return {2 * KILN_VISIBLE_NOH * std::sqrt(u / rest) * cosine, 1 / rest, 0, 0, 0, NoV};
}

std::size_t point_scalars(PointKind kind) {
    return kind == PointKind::facet_walk ? kWalkScalars : kPointScalars;
}

PointKind point_kind(const KernelMaterial& material) {
    if (material.importance == kLogTangents) return PointKind::log_tangents;
    if (material.importance == kHorizonNormals) return PointKind::horizon_normals;
    if (material.importance == kVisibleLights) return PointKind::visible_lights;
    if (material.importance == kPartedLights)
        return material.terms & KILN_TERMS_DIFFUSE ? PointKind::parted_lights_diffuse
                                                   : PointKind::parted_lights;
    if (material.diffuse == KILN_DIFFUSE_GGX_LAMBERT && material.terms & KILN_TERMS_DIFFUSE)
        return PointKind::facet_walk;
    switch (static_cast<Importance>(material.importance)) {
        case Importance::vndf:
            return PointKind::visible_normals;
        case Importance::ndf:
            return static_cast<Distribution>(material.distribution) == Distribution::beckmann
                       ? PointKind::beckmann_normals
                       : PointKind::ggx_normals;
        case Importance::cosine:
            return PointKind::cosine;
        case Importance::uniform:
            return PointKind::uniform;
    }
    __builtin_unreachable();
}

PointSet make_points(Sampler sampler, PointKind kind, std::uint64_t seed,
                     std::int64_t sample_count) {
    return make_more_points(sampler, kind, seed, 0, sample_count);
}

PointSet make_more_points(Sampler sampler, PointKind kind, std::uint64_t seed, std::int64_t before,
                          std::int64_t after) {
    const auto total = static_cast<std::uint64_t>(after);
    const std::uint64_t had = is_nested(sampler) ? static_cast<std::uint64_t>(before) : 0;
    const auto replicates = std::min<std::uint64_t>(total, kReplicatesMax);
    PointSet set;
    set.values.reserve((total - had) * point_scalars(kind));
    for (std::uint32_t r = 0; r < replicates; ++r) {
        const auto part = [&](std::uint64_t whole) {
            return static_cast<std::uint32_t>(whole * (r + 1) / replicates -
                                              whole * r / replicates);
        };
        const std::uint32_t size = part(total), start = part(had);
        const Generator generate(sampler, kind, seed, r, size);
        for (std::uint32_t at = start; at < size;) {
            const std::uint32_t end = std::min(batch_end(at), size);
            set.batches.push_back(
                {static_cast<std::uint32_t>(set.values.size() / point_scalars(kind)), end - at});
            set.replicate_of_batch.push_back(r);
            for (; at < end; ++at) append(set.values, kind, generate(at));
        }
        set.replicate_sizes.push_back(size);
    }
    return set;
}

}  // namespace kiln
