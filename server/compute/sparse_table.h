// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "server/compute/axes.h"
#include "server/compute/quadrature.h"

namespace kiln {

/// Where a smooth function of one axis is known, and how to find it between: cubic Lagrange
/// polynomials over the four knots around, whatever their distances.
class KnotLine {
  public:
    /// Knots among the texels 0 … count - 1, those two with them: every texel at the end where the
    /// parameter is lowest, then ever further apart, by 1 / `thinning` of the distance from that
    /// end and at most `apart_max`. Some 4 texels are the least. `positions`: where they are, if
    /// not at 0, 1, 2 and on: places of a lattice leave gaps.
    KnotLine(std::int64_t count, bool flip, std::size_t thinning, std::size_t apart_max,
             const std::vector<double>& positions = {});

    struct Between {
        std::size_t cell = 0;   ///< knots cell and cell + 1 are around the texel
        std::size_t first = 0;  ///< of the four knots
        std::array<double, 4> weight{};
    };
    Between at(std::size_t texel) const {
        const std::size_t cell = cells_[texel];
        return {cell,
                first(cell),
                {weights_[0][texel], weights_[1][texel], weights_[2][texel], weights_[3][texel]}};
    }
    /// From the values at all knots those at texels `begin` to `end`, which go to `to` on.
    void interpolate(const double* knots, std::size_t begin, std::size_t end, double* to) const;
    const std::vector<std::size_t>& knots() const { return knots_; }
    std::size_t cells() const { return knots_.size() - 1; }
    /// Calls body(cell, first texel, last texel + 1) for the cells of texels `begin` < `end`.
    template <typename Body>
    void each_cell(std::size_t begin, std::size_t end, Body body) const {
        for (std::size_t cell = cells_[begin]; begin < end; ++cell) {
            const std::size_t stop = cell + 1 < cells() ? std::min(knots_[cell + 1], end) : end;
            body(cell, begin, stop);
            begin = stop;
        }
    }
    /// The texel of a cell where cubics are furthest off: that of the largest product of distances
    /// from its ends. The lower end where there is none between.
    std::size_t middle(std::size_t cell) const { return middles_[cell]; }

  private:
    /// The first of the four knots around a cell.
    std::size_t first(std::size_t cell) const {
        return std::clamp<std::size_t>(cell, 1, knots_.size() - 3) - 1;
    }

    std::vector<std::size_t> knots_, middles_;
    std::vector<std::size_t> cells_;              ///< of each texel
    std::array<std::vector<double>, 4> weights_;  ///< of the four knots around each texel
};

/// A directional table of two axes, integrated at the knots and in the middle of each cell between
/// them. Cells where interpolation finds the middle, and the middles around it, within a quarter of
/// the tolerance are interpolated; the others are integrated throughout. So the loosest tolerance
/// pays for a tenth of the texels or less.
class SparseTable {
  public:
    /// `deficit`: whether 1 - E is asked for; else it stays empty.
    SparseTable(const JobSpec& job, const Places& places, const QuadratureKind& kind,
                const QuadratureParameters& parameters, double tolerance, bool deficit,
                Backend& backend);

    /// Values and estimated errors of `count` places from `first` on. `evaluations` are those of
    /// this call; those of the constructor come with the first.
    QuadratureResult take(std::size_t first, std::size_t count);
    /// Places taken so far that were not integrated one by one.
    std::size_t interpolated() const { return interpolated_; }

  private:
    static constexpr std::size_t kPlanes = 3;  // E, the deficit, B
    using Values = std::array<std::vector<double>, kPlanes>;

    QuadratureResult integrate(const std::vector<std::size_t>& places,
                               const std::vector<std::uint8_t>& steps);
    void integrate_knots();
    void judge_cells();
    template <typename T>
    T most_around(const std::vector<T>& of_knots, std::size_t cell_x, std::size_t cell_y) const;
    void interpolate(std::size_t row, std::size_t begin, std::size_t end, std::size_t to,
                     QuadratureResult& result) const;
    struct Left;
    void note_cells(std::size_t row, std::size_t begin, std::size_t end, std::size_t to,
                    QuadratureResult& result, Left& left) const;
    double value_at(const std::vector<double>& plane, std::size_t x, std::size_t y) const;

    const Places& places_;
    const QuadratureKind kind_;
    const QuadratureParameters parameters_;
    const double tolerance_;
    Backend& backend_;
    const std::size_t width_;
    KnotLine columns_, rows_;
    const bool deficit_;
    Values knots_;                         ///< row-major over the knots
    std::vector<std::uint8_t> knot_step_;  ///< orders, as high as a neighbour's
    std::vector<float> knot_error_;        ///< of the quadrature there
    std::vector<float> cell_error_;        ///< of the interpolation; above the tolerance: integrate
    std::uint64_t evaluations_ = 0;        ///< not handed out yet
    std::size_t unsettled_ = 0;            ///< not handed out yet
    std::size_t interpolated_ = 0;
};

}  // namespace kiln
