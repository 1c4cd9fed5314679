// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <functional>
#include <vector>

#include "server/compute/table.h"
#include "server/spec/job_spec.h"

namespace kiln {

/// Where a table is held against exact values: on each axis some texels, dense at the end where the
/// parameter is 0 and at the other, thinner between, and halfway between each of them and its
/// neighbour. All texels of short axes.
class Lattice {
  public:
    /// `growth`: of the distance from one texel taken to the next, along x and y. Lookup is judged
    /// at the `parts` - 1 places that divide the way from a texel to its neighbour.
    explicit Lattice(const JobSpec& job, double growth = kFine, int parts = 2);
    static constexpr double kFine = 1.25, kCoarse = 2;
    /// As advice takes it, for reconstruction_bound().
    static Lattice dense(const JobSpec& job);

    /// The job whose table holds the lattice's places.
    const JobSpec& job() const { return lattice_; }
    std::size_t place_count() const;

    /// Calls body(place in the lattice's table, texel of the job's table, weight) for the places
    /// that are texels; a weight is the number of texels that the place stands for.
    void each_texel(const std::function<void(std::size_t, std::size_t, double)>& body) const;

    /// Largest difference of `exact`, a plane of the lattice's table, from bilinear (in three axes
    /// trilinear) lookup between its texels, as a shader does it: linear in texture coordinates,
    /// the edge's texel beyond the first and last centre. Over the lattice's places in between with
    /// NoV and alpha >= 1e-4, and at the rims.
    double reconstruction_max(const std::vector<float>& exact) const;
    /// Where that is: the axes' values there.
    std::vector<double> worst_place(const std::vector<float>& exact) const;
    /// That, and by how much parabolas through three places along an axis rise above the middle one
    /// where that is the largest of them, a sixteenth of their second difference at most: three in
    /// a row between two texels, and the same places of cells on either side of ones left out.
    double reconstruction_bound(const std::vector<float>& exact) const;

  private:
    /// Differences of lookups from `exact` at all places, 0 at those that are not judged.
    std::vector<double> differences(const std::vector<float>& exact) const;
    double rise(const std::vector<double>& off, const std::array<std::size_t, 3>& at,
                std::size_t axis) const;
    struct Line {
        std::vector<double> at;              // positions in texels, rising
        std::vector<bool> looked_up;         // is a place of lookup
        std::vector<std::size_t> low, high;  // where the two texels around it are in `at`
        std::vector<double> share;           // of the higher one
        std::vector<double> weight;          // texels that it stands for; 0 between texels
        std::int64_t count = 0;              // of the job's axis
        /// Neighbours of a place: between the same two texels, and in the cells next to its own
        /// where some were left out. Itself where there is none.
        std::vector<std::array<std::size_t, 2>> inner, outer;
    };
    static void find_neighbours(Line& line);
    static Line line(const Axis& axis, std::int64_t count, double growth, int parts);
    std::size_t index(const std::array<std::size_t, 3>& at) const;

    JobSpec lattice_;
    std::array<Line, 3> lines_;
};

/// Texels of an axis by their distance from either end, in rising order: 0, 1, 2 and on, each
/// `growth` further from the end where the parameter is lowest, growth^2 from the other.
std::vector<std::int64_t> ladder(std::int64_t count, bool flip, double growth);

/// The same estimated from a table alone, sampling noise and all: an eighth of the second
/// differences along each axis.
double estimated_reconstruction_max(const JobSpec& job, const std::vector<float>& plane);

}  // namespace kiln
