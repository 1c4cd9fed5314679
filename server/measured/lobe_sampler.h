// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <functional>
#include <vector>

#include "server/measured/resample.h"

namespace kiln::measured {

/// A direction with its density per solid angle; 0: the sample fell below the horizon.
struct Drawn {
    Vec out;
    double pdf = 0;
};

/// Discrete cells [row][column] by marginal and conditional sums.
class CellTable {
  public:
    CellTable(std::size_t rows, std::size_t columns, std::vector<double> mass);
    /// The cell of two numbers in [0, 1), and their places within it, again in [0, 1).
    struct Cell {
        std::size_t row = 0, column = 0;
        double row_share = 0, column_share = 0;
    };
    Cell draw(double a, double b) const;
    double probability(std::size_t row, std::size_t column) const;
    /// Running sums of rows, and of a row's cells, each to its end and of 1 in all.
    double row_sum(std::size_t row) const { return marginal_[row + 1] / marginal_.back(); }
    double cell_sum(std::size_t row, std::size_t column) const;
    std::size_t rows() const { return marginal_.size() - 1; }
    std::size_t columns() const { return columns_; }

  private:
    std::size_t columns_;
    std::vector<double> marginal_, conditional_;  ///< running sums that start at 0
};

/// Views in proportion to f cos(theta_o) under one theta_in: cells about the mirror direction that
/// end at the horizon, each of even density. No direction is left without.
class LobeSampler {
  public:
    LobeSampler(const LobeTables& tables, double theta_in, Resampler& resampler,
                std::size_t rings = 64, std::size_t spokes = 96);
    Drawn draw(double a, double b) const;
    double pdf(Vec out) const;
    const CellTable& cells() const { return cells_; }

  private:
    double end(double phi) const;  ///< sqrt(sin(theta_d / 2)) at the horizon
    double solid_angle(std::size_t ring, double phi) const;  ///< of a cell, by its end at phi
    double theta_in_;
    CellTable cells_;
};

/// A distribution of microfacet normals over theta_h, isotropic; integral of D cos = 1.
struct NormalDistribution {
    std::vector<double> theta, value;  ///< radians, rising; 1/sr
    double eigenvalue = 0;             ///< a quarter of the reflectance at normal incidence
    double at(double theta_h) const;   ///< linear, ends clamped
};
/// Power iteration of Dupuy, Heitz, Iehl, Poulin and Ostromoukhov 2015, "Extracting
/// Microfacet-based BRDF Parameters from Arbitrary Materials with Power Iterations": D is the
/// eigenvector of f_r(w, w) cos(theta) <w, h>. `retro` is f_r(w, w) at theta in radians.
NormalDistribution power_iteration(const std::function<double(double)>& retro);
/// Of a material's green channel. Throws Error("unfit_measurement") where nothing is reflected
/// back.
NormalDistribution normals_of(const LobeTables& tables, Resampler& resampler);

/// Views by mirroring the light at visible normals.
class VisibleNormalSampler {
  public:
    VisibleNormalSampler(const NormalDistribution& normals, double theta_in);
    Drawn draw(double a, double b) const;
    double pdf(Vec out) const;

  private:
    static constexpr std::size_t kRings = 128, kSpokes = 128;
    double density(std::size_t ring, std::size_t spoke) const;  ///< of normals, per solid angle
    Vec in_;
    CellTable cells_;
};

}  // namespace kiln::measured
