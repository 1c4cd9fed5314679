// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "server/base/rgb9e5.h"
#include "server/compute/table.h"
#include "server/measured/material.h"
#include "server/measured/physics.h"
#include "server/measured/predicted_error.h"

namespace kiln::measured {

/// How materials become one image. A slice is a latitude-longitude map about the mirror direction
/// of one theta_in: column c is phi_d = 360 c / (width - 1), row r is theta_d = 180 r / (height -
/// 1) degrees. Slices follow each other in rows, theta_in rising; in an atlas each slice is a grid
/// of cells, one a material, in rows.
struct SliceLayout {
    /// Degrees, rising. The paper has every 20; linear steps of 5 lose a sixteenth of that.
    std::vector<double> theta_in{0, 5, 10, 15, 20, 25, 30, 35, 40, 45, 50, 55, 60};
    std::size_t width = 361, height = 181;
    std::size_t gutter = 0;  ///< texels around each cell: phi_d goes on around, theta_d ends
    bool conserve = false;   ///< make materials reciprocal and energy-conserving first (physics.h)
};

/// Where everything lies, in texels.
struct SlicePlan {
    std::size_t width = 0, height = 0;            ///< of the image
    std::size_t cell_width = 0, cell_height = 0;  ///< of a slice of one material with its gutter
    std::size_t slice_columns = 0, cell_columns = 0, cell_rows = 0;
    struct Place {
        std::size_t x = 0, y = 0;  ///< of the first texel inside the gutter
    };
    Place place(const SliceLayout& layout, std::size_t slice, std::size_t material) const;
};
/// Throws Error("too_large") for an image beyond the contract's limits.
SlicePlan plan_slices(const SliceLayout& layout, std::size_t material_count);

/// What a table lost and where its values come from, for one material.
struct SliceAccount {
    double measured = 0, interpolated = 0,
           extrapolated = 0;               ///< shares of texels above the horizon
    std::size_t negative = 0;              ///< values that were raised to 0
    std::vector<Material::Albedo> albedo;  ///< one a theta_in
    Material::Albedo average;
    Physics measured_physics;  ///< of the material as it was measured
    Physics physics;           ///< of what the table holds: another one where it was conserved
    PredictedError predicted;
    Between between = Between::linear;
    std::vector<double> incidences;  ///< of the file, degrees
    std::vector<double> gaps;        ///< theta_in_errors()
    std::vector<std::string> warnings;
};

struct SliceTable {
    SlicePlan plan;
    Table table;  ///< channels R, G, B and origin (Origin's numbers, 3 below the horizon)
    std::vector<SliceAccount> accounts;  ///< one a material
};
/// Resampled and integrated in the kernels of `backend`, which has built resampler_kernels() where
/// it builds any; null: native, on all cores. `tell` hears the part that is done after each slice;
/// what it throws ends the work.
SliceTable make_slices(
    const SliceLayout& layout, const std::vector<const Material*>& materials,
    const std::function<void(double fraction)>& tell = [](double) {}, Backend* backend = nullptr);

/// What a shader has to know, as JSON text: sizes, angles, places, and the formulas with their half
/// texels.
std::string sidecar_json(const SliceLayout& layout, const SliceTable& made,
                         const std::vector<std::string>& names);

/// The view of a texel of one slice; columns beyond a whole turn and rows beyond a pole are those
/// of a gutter.
Vec view_of(const SliceLayout& layout, double theta_in, double column, double row);

/// What a shader finds in the image: trilinear among slices, clamped in theta_in.
Colour look_up(const SliceLayout& layout, const SliceTable& made, std::size_t material,
               double theta_in, Vec out);

}  // namespace kiln::measured
