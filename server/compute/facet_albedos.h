// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "server/compute/thread_pool.h"

namespace kiln {

/// What quadrature of ggx_lambert gives at some places, in their order.
struct FacetAlbedos {
    std::vector<std::vector<double>> of;  ///< by albedo of the facets, then by place
    /// Difference of the last two rules, the largest of some NoV: a bound on that of the value.
    std::vector<float> error;
    std::uint64_t evaluations = 0;  ///< pairs of directions that light goes between
    std::size_t unsettled = 0;      ///< places whose error is above the tolerance
};

struct FacetPlaces {
    std::span<const double> NoV;  ///< empty: averages over it
    std::span<const double> alpha;
    std::span<const double> rhos;  ///< of the facets
};

/// Albedos of Lambertian GGX facets (facet_space.h), all places of one alpha after each other, on
/// all threads; the rule is refined until two agree. `tolerance` is asked between groups of places
/// with the share that is done, and may throw: absolute, 1e-9 is within reach.
FacetAlbedos facet_albedos(const FacetPlaces& places, ThreadPool& pool,
                           const std::function<double(double)>& tolerance);

}  // namespace kiln
