// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstddef>
#include <string_view>
#include <vector>

#include "server/measured/angles.h"
#include "server/measured/cloud.h"
#include "server/measured/tensor_file.h"

namespace kiln::measured {

/// A table over [0, 1]^2, bilinear between nodes, one for each incidence.
struct NodeTable {
    std::size_t width = 0, height = 0, slices = 0;
    std::vector<float> values;  ///< [slice][y][x]
};

/// A material of the RGL database (Dupuy and Jakob 2018, "An adaptive parameterization for
/// efficient material acquisition and rendering"), evaluated as its authors define it.
class RglBrdf {
  public:
    /// Throws Error("malformed_measurement", "byte N: …"); Error("unreadable_measurement") for
    /// azimuths of the light over no whole, half or quarter turn, and for spectra that leave out a
    /// part of what the eye sees.
    explicit RglBrdf(std::string_view bytes);

    /// The stored quantity, f_r cos theta_o in 1/sr. Negative values (colours outside sRGB) are
    /// given as they are.
    std::array<double, 3> value(Vec in, Vec out) const;
    /// The same of light at one of theta_i() and one of phi_i(): along the normal, each azimuth has
    /// a slice of its own.
    std::array<double, 3> value_at(double theta_i, double phi_i, Vec out) const;

    /// Nanometres of a spectral file, whose R, G and B are srgb_weights() of it; empty of others.
    const std::vector<double>& wavelengths() const { return wavelengths_; }
    /// Light angles of the slices in degrees, rising.
    const std::vector<double>& theta_i() const { return theta_i_; }
    /// Azimuths of the light in degrees, rising; one, 0, of an isotropic material.
    const std::vector<double>& phi_i() const { return phi_i_; }
    bool isotropic() const { return phi_i_.size() == 1; }
    /// What stands for azimuths that the file leaves out.
    TurnSymmetry symmetry() const { return symmetry_; }
    /// Whether the last slice repeats the one before it: then nothing was measured there.
    bool last_is_copy() const { return last_is_copy_; }
    const NodeTable& visible_normals() const { return vndf_; }
    std::string_view description() const { return description_; }

    /// Half vector in degrees at a place of the unit square: of an isotropic material the light
    /// stands at azimuth 0.
    static Vec half_vector(double u, double v);
    /// Share of the places on a grid of half vectors whose `valid` bit is set, above the horizon
    /// and below. NaN where the file has no such field.
    std::array<double, 2> valid_share() const;

  private:
    void load_tables(std::string_view bytes);
    void load_azimuths(std::string_view bytes, const TensorField& field);
    bool repeats_last_slice() const;
    NodeTable seen(const NodeTable& spectra) const;
    void build_distribution();
    struct Place {
        double u = 0, v = 0;  ///< on the unit square
    };
    /// Slices about a direction of light, and the share of each.
    struct Mix {
        std::array<std::size_t, 4> slice{};
        std::array<double, 4> share{};
        std::size_t count = 0;
    };
    Mix mix_at(double theta_i, double phi_i) const;
    Place warp(const Mix& mix, double u, double v) const;
    void into_range(Vec& in, Vec& out) const;

    std::vector<double> theta_i_, wavelengths_, phi_i_{0};
    TurnSymmetry symmetry_ = TurnSymmetry::any_turn;
    bool last_is_copy_ = false;
    bool jacobian_ = true;
    NodeTable vndf_, rgb_, ndf_, sigma_;  ///< rgb has three slices an incidence
    std::vector<double> conditional_, marginal_;
    std::vector<unsigned char> valid_;
    std::string_view description_;
};

}  // namespace kiln::measured
