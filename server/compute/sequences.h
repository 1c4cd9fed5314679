// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "server/spec/job_spec.h"

namespace kiln {

// Azimuth and polar angle of each direction, before them the inclination of a walk's facet, then
// NoV of averages. Azimuths are in half turns: the integrand is even in them.
inline constexpr std::size_t kDimensions = 3, kWalkDimensions = 3, kWalkRowFacets = 5,
                             kDimensionsMax = kWalkDimensions * kWalkRowFacets + 1;
using UniformPoint = std::array<double, kDimensionsMax>;  ///< strictly inside (0, 1)

/// The points of one replicate: point i is a function of what the constructor is told, the same on
/// every machine.
class Sequence {
  public:
    /// `dimensions`: kDimensions, or kDimensionsMax of a walk. Sets whose dimensions, from
    /// `first_dimension` on, do not overlap are independent. `size`: how many points the replicate
    /// has.
    Sequence(Sampler sampler, std::size_t dimensions, std::size_t first_dimension,
             std::uint64_t seed, std::uint32_t replicate, std::uint32_t size);
    UniformPoint operator()(std::uint32_t i) const;

  private:
    bool pairs_within_batches() const;
    UniformPoint halton(std::uint32_t i) const;
    UniformPoint lattice(std::uint32_t i) const;
    UniformPoint sobol(std::uint32_t i) const;
    UniformPoint random(std::uint32_t i) const;
    UniformPoint shifted(UniformPoint point) const;

    Sampler sampler_;
    std::uint32_t size_;
    std::size_t dimensions_;
    std::array<std::uint64_t, kDimensionsMax> key_{};
    UniformPoint shift_{};
};

}  // namespace kiln
