// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "server/compute/plan.h"
#include "server/compute/thread_pool.h"

namespace kiln {

/// One launch of a region: the kernel, and the points that it takes.
struct Draw {
    Specialisation what;
    PointKind points = PointKind::visible_normals;
};

/// The places of a pass that are sampled alike.
struct Region {
    std::vector<std::uint32_t> places;  ///< rising
    std::vector<Draw> draws;
    /// 1 − E comes from a draw of its own, the last, and all else is put right by it (estimate.h).
    bool deficit_apart = false;
    /// Those that parted lights draw (kernels/parted_lights.h).
    int parted_terms = 0;
};

/// Every place of a pass, once. Where 1 − E is small, visible normals hardly ever meet what carries
/// it; there it is drawn by log-uniform tangents, of averages by horizon normals. At low roughness
/// many samples of E, A and B are drawn above the horizon alone. A pass without such places has one
/// region.
std::vector<Region> regions_of(const Pass& pass, std::int64_t sample_count, ThreadPool& pool);

/// The kernels of a pass, the one of its terms first.
std::vector<Specialisation> kernels_of(const Pass& pass, std::int64_t sample_count);
/// The kernel that draws the deficit alone.
Specialisation deficit_kernel(const Specialisation& what);

/// Where the sums of each term lie: of batch b at data[term] + b · step[term].
template <typename Scalar>
struct TermSums {
    std::array<const Scalar*, kTermCount> data{};
    std::array<std::size_t, kTermCount> step{};
};

/// The launches of a region at some of its places.
template <typename Scalar>
class Launches {
  public:
    Launches(Backend& backend, ThreadPool& pool, const Pass& pass, const Region& region);

    /// Points of the draw with that index; all draws have equal batches.
    void set_points(std::size_t draw, const PointSet& set);
    /// At most Backend::block_places(). Lanes past the end repeat the last place.
    void set_places(std::span<const std::uint32_t> places);
    std::size_t stride() const { return stride_; }
    /// Valid until the next call.
    TermSums<Scalar> run(std::span<const BatchRange> batches);

  private:
    Backend& backend_;
    ThreadPool& pool_;
    const Pass& pass_;
    const Region& region_;
    std::vector<Scalar> parameters_, texels_;
    /// Memory that a launch writes in full: never cleared, and never copied as it grows.
    struct Sums {
        std::unique_ptr<Scalar[]> data;
        std::size_t count = 0;
    };
    std::vector<std::vector<Scalar>> points_;  // [draw]
    std::vector<Sums> sums_;                   // [draw]
    std::size_t stride_ = 0;
};

}  // namespace kiln
