// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>
#include <vector>

#include "server/measured/incidence.h"
#include "server/measured/triangulation.h"

namespace kiln::measured {

/// Where a value comes from.
enum class Origin : std::uint8_t {
    kMeasured = 0,      ///< between measured points that are neighbours
    kInterpolated = 1,  ///< across a hole of the measurement
    kExtrapolated = 2,  ///< beyond it
};

/// One incidence as a continuous function: linear on a triangulation of the disk (x, y) of view
/// directions, on which cos(theta_o) d omega is plain area, so that albedos are sums over
/// triangles.
class Hemisphere {
  public:
    /// Needs three usable points that are not in one line for anything but `albedo` of patches.
    Hemisphere(const Incidence& incidence, std::size_t channels);

    double theta_i() const { return theta_i_; }
    double phi_i() const { return phi_i_; }  ///< as in the file, degrees
    std::size_t channels() const { return channels_; }
    bool has_area() const { return !inner_.empty(); }

    /// f_r at a view direction within the hull of the points into values[channels]. False outside.
    /// `hint` makes a walk over neighbouring directions short.
    bool value(Vec out, std::uint32_t& hint, double* values, Origin& origin) const;

    /// Integral of f cos(theta_o) over the hull, or over the patches of the file, a channel each.
    std::vector<double> albedo() const;
    /// Share of the hemisphere, by projected solid angle, within the hull.
    double coverage() const;
    /// Lower quartiles of how wide the triangles are about the mirror direction: in the root of
    /// sin(theta_d / 2), and in turns of phi_d.
    struct Spacing {
        double root = 0, turn = 0;
    };
    Spacing spacing() const;
    /// Points apart from each other are left out with their neighbours and predicted from the rest;
    /// `round` picks others. Sums over them by the area that they stand for, of the channels' sum:
    /// |prediction - value|, |value|.
    struct Prediction {
        double off = 0, all = 0;
    };
    Prediction leave_regions_out(std::uint64_t round) const;
    std::size_t node_count() const { return node_values_.size() / channels_; }

  private:
    void find_holes(const Incidence& incidence);

    double theta_i_, phi_i_;
    std::size_t channels_;
    std::unique_ptr<Triangulation> mesh_;
    std::vector<float> node_values_;  ///< [node - 3][channel]
    std::vector<std::uint32_t> inner_;
    std::vector<Origin> triangle_origin_;  ///< of every triangle
    std::vector<double> patch_albedo_;     ///< where the file has patches
    double patch_coverage_ = 0;
};

/// Relative differences |a - b| / mean of f(i, o) and f(o, i), where both are measured, over pairs
/// of the given hemispheres, which lie by theta_i, and all azimuths; of a file with several
/// azimuths of the light under one theta_i, which may be of a surface that turns, over the azimuths
/// that both have. Of the channels' sum.
struct ReciprocityError {
    std::size_t pairs = 0;
    double median = 0, p95 = 0;
};
ReciprocityError reciprocity_error(const std::vector<Hemisphere>& incidences);

}  // namespace kiln::measured
