// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "server/measured/slices.h"

namespace kiln::measured {
namespace {

using json = nlohmann::ordered_json;

json albedo_json(const Material::Albedo& albedo) {
    return {{"rgb", albedo.value}, {"extrapolated_share", albedo.extrapolated}};
}

/// What RGB9_E5 would make of a material's texels: relative error of the largest channel's scale.
json rgb9e5_json(const SliceLayout& layout, const SliceTable& made, std::size_t material) {
    double sum = 0, most = 0;
    std::size_t count = 0, flushed = 0;
    for (std::size_t s = 0; s < layout.theta_in.size(); ++s) {
        const SlicePlan::Place at = made.plan.place(layout, s, material);
        for (std::size_t row = 0; row < layout.height; ++row)
            for (std::size_t column = 0; column < layout.width; ++column) {
                const std::size_t n = (at.y + row) * made.plan.width + at.x + column;
                Colour c{};
                for (std::size_t k = 0; k < 3; ++k) c[k] = made.table.planes[k][n];
                const Colour back = from_rgb9e5(to_rgb9e5(c));
                for (std::size_t k = 0; k < 3; ++k) {
                    if (c[k] <= 0) continue;
                    const double error = std::abs(back[k] / c[k] - 1);
                    sum += error;
                    most = std::max(most, error);
                    flushed += back[k] == 0;
                    ++count;
                }
            }
    }
    return {{"relative_error_mean", count > 0 ? sum / static_cast<double>(count) : 0.0},
            {"relative_error_max", most},
            {"channels_flushed_to_zero", flushed}};
}

json material_json(const SliceLayout& layout, const SliceTable& made, std::size_t material,
                   const std::string& name) {
    const SliceAccount& account = made.accounts[material];
    json slices = json::array();
    for (std::size_t s = 0; s < layout.theta_in.size(); ++s) {
        const SlicePlan::Place at = made.plan.place(layout, s, material);
        slices.push_back({{"theta_in_deg", layout.theta_in[s]},
                          {"x", at.x},
                          {"y", at.y},
                          {"directional_albedo", albedo_json(account.albedo[s])}});
    }
    return {{"index", material},
            {"name", name},
            {"texels",
             {{"measured_share", account.measured},
              {"interpolated_share", account.interpolated},
              {"extrapolated_share", account.extrapolated},
              {"negative_raised_to_zero", account.negative}}},
            {"average_albedo", albedo_json(account.average)},
            {"rgb9e5", rgb9e5_json(layout, made, material)},
            {"slices", slices},
            {"warnings", account.warnings}};
}

}  // namespace

std::string sidecar_json(const SliceLayout& layout, const SliceTable& made,
                         const std::vector<std::string>& names) {
    json materials = json::array();
    for (std::size_t m = 0; m < made.accounts.size(); ++m)
        materials.push_back(material_json(layout, made, m, m < names.size() ? names[m] : ""));
    const std::string w = std::to_string(layout.width), h = std::to_string(layout.height);
    const json document = {
        {"image", {{"width", made.plan.width}, {"height", made.plan.height}}},
        {"slice", {{"width", layout.width}, {"height", layout.height}, {"gutter", layout.gutter}}},
        {"theta_in_deg", layout.theta_in},
        {"grid",
         {{"slice_columns", made.plan.slice_columns},
          {"cell_columns", made.plan.cell_columns},
          {"cell_rows", made.plan.cell_rows},
          {"cell_width", made.plan.cell_width},
          {"cell_height", made.plan.cell_height}}},
        {"channels", made.table.channels},
        {"origin_channel", "the fourth, which an EXR names A; a PNG has none"},
        {"origin_values",
         {{"0", "measured"}, {"1", "interpolated"}, {"2", "extrapolated"}, {"3", "below horizon"}}},
        {"units", "f_r in 1/sr, linear sRGB; no cosine"},
        {"shader",
         {{"frame",
           "tangent t = light projected onto the surface; d = S v with S = ((-c, 0, -s), "
           "(0, -1, 0), (-s, 0, c)), c and s of theta_in"},
          {"column", "phi_d / (2 pi) * (" + w + " - 1) + 0.5, in texels from x of the slice"},
          {"row", "theta_d / pi * (" + h + " - 1) + 0.5, in texels from y of the slice"},
          {"slice", "linear between the two theta_in around the light's, clamped at the ends"}}},
        {"materials", materials}};
    return document.dump(1);
}

}  // namespace kiln::measured
