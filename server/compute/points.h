// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "server/compute/native_group.h"
#include "server/spec/job_spec.h"

namespace kiln {

/// Scalars a point as the kernels take it (kernels/batch.h), of every kind but facet_walk
/// (kernels/ggx_lambert.h).
inline constexpr std::size_t kPointScalars = 4;
inline constexpr std::size_t kWalkScalars = 16;

/// Replicates of a job: independently randomised point sets, from whose spread the standard error
/// comes. 16 leaves the factor of a 95 % interval at 2.13 (Student's t), and the sets large.
inline constexpr std::int64_t kReplicatesMax = 16;

/// Longest run of points that is summed in working precision; longer runs would grow rounding in
/// float from 1e-5 (1024 points) to 6e-5 (4096).
inline constexpr std::uint32_t kBatchPointsMax = 1024;

/// What a point's first three scalars are: the sampler that takes them (kernels/ggx.h,
/// kernels/microfacet.h, kernels/diffuse.h).
enum class PointKind {
    visible_normals,
    ggx_normals,
    beckmann_normals,
    cosine,
    uniform,
    cosine_diffuse,  ///< as cosine, from a set of its own: independent of the specular lobe's
    facet_walk,      ///< three facets on a walk, from a set of its own
};
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
};

/// Sample i of replicate r is a function of (sampler, seed, r, i) and, for sets whose shape depends
/// on their size, of the replicate's size: the same on every machine. Coordinates lie strictly
/// inside (0, 1).
PointSet make_points(Sampler sampler, PointKind kind, std::uint64_t seed,
                     std::int64_t sample_count);

/// cos(2πu) for u in [0, 1]: + − × alone, so that no C library's version can change a table. Error
/// ≤ 2e-16.
double cos_turn(double u);

}  // namespace kiln
