// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "server/compute/backend.h"
#include "server/compute/engine.h"
#include "server/compute/thread_pool.h"

namespace kiln {

/// A table that could be baked, and its largest errors over all channels.
struct Candidate {
    JobSpec job;              ///< complete; baked by quadrature
    std::uint64_t bytes = 0;  ///< of its texels, uncompressed
    /// Bounds; reconstruction by Lattice::dense(), at most a third above what is seen between
    /// texels.
    double integration = 0, quantisation = 0, reconstruction = 0;
    double total() const { return integration + quantisation + reconstruction; }
};

/// What came nearest to a bound that nothing keeps.
struct Closest {
    Candidate table;
    std::string channel;     ///< whose lookups are off the most,
    std::vector<double> at;  ///< and where: a value on each axis
};

/// Texels along x and y that advice considers.
inline constexpr std::int64_t kAdvisedSizes[] = {8,   16,  24,  32,  48,   64,   96,   128,  192,
                                                 256, 384, 512, 768, 1024, 1536, 2048, 3072, 4096};

/// For every axis mapping (those of a program's layout are left as they are), grid and pixel type
/// of the job's format the smallest square table whose three errors together stay within
/// `max_error`, and the smallest three of them with fewer texels along one axis, then along the
/// other, as far as that holds; smallest in bytes first; of those that are equally good, as where
/// an axis changes nothing, one. Sizes are the smallest of kAdvisedSizes, not of all there are.
/// Empty where none does up to 4096: `closest` then has the smallest error, which may be larger
/// between the places of a coarse lattice. Grids with a texel on a pole of the lobe are passed
/// over. Every quantity of the job needs quadrature (quadrature_lacks in server/spec/channels.h).
/// Throws Cancelled, Error("non_finite") where all grids have one.
std::vector<Candidate> advise(const JobSpec& job, double max_error, Backend& native,
                              ThreadPool& pool, const Control& control,
                              std::optional<Closest>* closest = nullptr);

/// The pixel types that advice considers, the finest last.
std::vector<PixelType> advised_pixels(ImageFormat format);

/// The largest error of a pixel type for values up to `most`.
double quantisation_bound(PixelType pixel, double most);

}  // namespace kiln
