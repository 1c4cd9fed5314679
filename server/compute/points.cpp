// SPDX-License-Identifier: Apache-2.0
#include "server/compute/points.h"

#include <algorithm>
#include <cmath>

#include "server/compute/one_lane.h"
#include "server/compute/sequences.h"
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
              kWalkScalars == KILN_WALK_SCALARS && kWalkDimensions == KILN_WALK_FACET_SCALARS &&
              kWalkRowFacets == KILN_WALK_ROW_FACETS);
static_assert(kLogTangents == KILN_IMPORTANCE_LOG_TANGENTS &&
              kVisibleLights == KILN_IMPORTANCE_VISIBLE_LIGHTS &&
              kPartedLights == KILN_IMPORTANCE_PARTED_LIGHTS &&
              kHorizonNormals == KILN_IMPORTANCE_HORIZON_NORMALS &&
              kCharlieSoftened == KILN_MASKING_CHARLIE_SOFTENED);

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
void append_walk(std::vector<double>& values, const UniformPoint& point) {
    for (std::size_t d = 0; d + 1 < kDimensionsMax; d += kWalkDimensions) {
        // An even disc: √v cos ψ along lines that reach √(1 − v sin² ψ) to either side.
        const double v = point[d + 2], cosine = cos_turn(point[d + 1] / 2);
        const double x = std::sqrt(v) * cosine,
                     reach = std::sqrt(1 - v * (1 - cosine) * (1 + cosine));
        values.insert(values.end(), {point[d], (reach - x) / 2, (reach + x) / 2});
    }
    values.push_back(std::sqrt(point[kDimensionsMax - 1]));
}

/// What the kind's sampler takes, of most the square of the second after three; the NoV of an
/// average, √u, which is ∫ 2 NoV dNoV uniformly.
void append(std::vector<double>& values, PointKind kind, const UniformPoint& point) {
    const double u = point[1], rest = 1 - u, cosine = cos_turn(point[0] / 2);
    const double NoV = std::sqrt(point[2]);
    switch (kind) {
        case PointKind::visible_normals: {
            const auto scalars = visible_normal_point(cosine, u, NoV);
            values.insert(values.end(), scalars.begin(), scalars.end());
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
    values.insert(values.end(), {second * second, 0, NoV});
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
        const Sequence generate(sampler, dimensions(kind), first_dimension(kind), seed, r, size);
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
