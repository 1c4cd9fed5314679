// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

#include "server/compute/native_group.h"
#include "server/compute/terms.h"
#include "server/spec/job_spec.h"

namespace kiln {

/// Scalars a point as the kernels take it (kernels/batch.h), of every kind but facet_walk
/// (kernels/ggx_lambert.h).
inline constexpr std::size_t kPointScalars = 6;
inline constexpr std::size_t kWalkScalars = 16;

/// Replicates of a job: independently randomised point sets, from whose spread the standard error
/// comes. 16 leaves the factor of a 95 % interval at 2.13 (Student's t), and the sets large.
inline constexpr std::int64_t kReplicatesMax = 16;

/// Longest run of points that is summed in working precision; longer runs would grow rounding in
/// float from 1e-5 (1024 points) to 6e-5 (4096).
inline constexpr std::uint32_t kBatchPointsMax = 1024;

/// A replicate's first run; the next ones end at powers of two until they are as long as a batch
/// may be. Sums over the first 2^k points are then the same bits in a longer replicate.
inline constexpr std::uint32_t kFirstBatchPoints = 64;

/// What a point's scalars are: the sampler that takes them (kernels/ggx.h, kernels/microfacet.h,
/// kernels/diffuse.h and those below), but for the last, the NoV of averages (kernels/batch.h).
enum class PointKind {
    visible_normals,
    ggx_normals,
    beckmann_normals,
    cosine,
    uniform,
    cosine_diffuse,  ///< as cosine, from a set of its own: independent of the specular lobe's
    visible_lights,  ///< visible normals that mirror the view above the horizon
    parted_lights,   ///< the same on both sides of the rim of total reflection
    parted_lights_diffuse,  ///< transmitted lights, from the set of cosine_diffuse
    log_tangents,           ///< tan θ = α sinh v, v nearly uniform: the deficit at low roughness
    horizon_normals,        ///< normals towards the view's horizon: the deficit of averages
    facet_walk,             ///< five facets on a walk, from a set of its own
};
/// The importances by which the kernels know what no job spells.
inline constexpr int kLogTangents = KILN_IMPORTANCE_COUNT;
inline constexpr int kHorizonNormals = KILN_IMPORTANCE_COUNT + 1;
inline constexpr int kVisibleLights = KILN_IMPORTANCE_COUNT + 2;
inline constexpr int kPartedLights = KILN_IMPORTANCE_COUNT + 3;

/// The kind that a specular lobe takes, or a walk over facets.
PointKind point_kind(const KernelMaterial& material);
std::size_t point_scalars(PointKind kind);

/// All points of a job in the order in which they are summed.
struct PointSet {
    std::vector<double> values;  ///< point_scalars() of its kind a point
    std::vector<BatchRange> batches;
    std::vector<std::uint32_t> replicate_of_batch;
    std::vector<std::uint32_t>
        replicate_sizes;  ///< points in each replicate; they differ by at most one

    std::uint64_t samples() const {  ///< of a texel, in all replicates
        return std::accumulate(replicate_sizes.begin(), replicate_sizes.end(), std::uint64_t{0});
    }
};

/// Sample i of replicate r is a function of (sampler, seed, r, i) and, for sets whose shape depends
/// on their size, of the replicate's size: the same on every machine. Coordinates lie strictly
/// inside (0, 1).
PointSet make_points(Sampler sampler, PointKind kind, std::uint64_t seed,
                     std::int64_t sample_count);

/// Whether the first points of a longer replicate are those of a shorter one.
constexpr bool is_nested(Sampler sampler) {
    return sampler == Sampler::sobol_owen || sampler == Sampler::random;
}

/// What make_points(…, after) has beyond make_points(…, before), of a nested sampler; all of the
/// former, of another or where before is 0. replicate_sizes are those of `after`.
PointSet make_more_points(Sampler sampler, PointKind kind, std::uint64_t seed, std::int64_t before,
                          std::int64_t after);

/// cos(2πu) for u in [0, 1]: + − × alone, so that no C library's version can change a table. Error
/// ≤ 2e-16.
double cos_turn(double u);

/// A point of visible_normals (kernels/ggx.h), from the cosine of its azimuth and u in (0, 1).
std::array<double, kPointScalars> visible_normal_point(double cosine, double u, double NoV = 0);

}  // namespace kiln
