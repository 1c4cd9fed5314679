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

json reciprocity_json(const Reciprocity& found) {
    return {{"mean", found.l1}, {"median", found.median}, {"p95", found.p95}};
}

json physics_json(const Physics& physics) {
    json albedo = json::array();
    for (std::size_t n = 0; n < physics.theta_in.size(); ++n)
        albedo.push_back({{"theta_in_deg", physics.theta_in[n]},
                          {"rgb", physics.albedo[n].value},
                          {"extrapolated_share", physics.albedo[n].extrapolated}});
    json measured = reciprocity_json(physics.measured);
    measured["share_of_pairs"] = physics.measured_pairs;
    return {{"albedo_max", physics.albedo_max},
            {"albedo_max_theta_in_deg", physics.albedo_max_theta_in},
            {"extrapolated_share", physics.extrapolated},
            {"albedo", albedo},
            {"reciprocity", reciprocity_json(physics.all)},
            {"reciprocity_where_measured", measured}};
}

json predicted_json(const PredictedError& error) {
    json theta_in;
    if (error.knows_theta_in) theta_in = error.theta_in;
    return {{"at_incidences", error.at_incidences()},
            {"between_incidences", error.between_incidences()},
            {"points", error.points},
            {"azimuths", error.azimuths},
            {"texels", error.table},
            {"theta_in", theta_in},
            {"slices", error.slices}};
}

/// Of one slice, read at its own theta_in; null beyond the file's incidences, and between them
/// where fewer than three tell nothing.
json slice_error_json(const SliceAccount& account, double theta_in) {
    constexpr double kSame = 1e-3;  // degrees
    const std::vector<double>& at = account.incidences;
    const double own = account.predicted.at_incidences();
    for (const double incidence : at)
        if (std::abs(incidence - theta_in) < kSame) return own;
    const auto above = std::upper_bound(at.begin(), at.end(), theta_in);
    if (above == at.begin() || above == at.end() || account.gaps.empty()) return nullptr;
    return own + account.gaps[static_cast<std::size_t>(above - at.begin()) - 1];
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
                          {"directional_albedo", albedo_json(account.albedo[s])},
                          {"predicted_error", slice_error_json(account, layout.theta_in[s])}});
    }
    json entry = {{"index", material},
                  {"name", name},
                  {"texels",
                   {{"measured_share", account.measured},
                    {"interpolated_share", account.interpolated},
                    {"extrapolated_share", account.extrapolated},
                    {"negative_raised_to_zero", account.negative}}},
                  {"average_albedo", albedo_json(account.average)},
                  {"rgb9e5", rgb9e5_json(layout, made, material)},
                  {"between_incidences", to_string(account.between)},
                  {"predicted_error", predicted_json(account.predicted)},
                  {"physics", physics_json(account.physics)},
                  {"slices", slices},
                  {"warnings", account.warnings}};
    if (layout.conserve) entry["physics_as_measured"] = physics_json(account.measured_physics);
    return entry;
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
          {"azimuth",
           "a material with phi_in_deg is for light at that azimuth, counter-clockwise from the "
           "sample's x axis as seen against the normal; others are for light at any"},
          {"column", "phi_d / (2 pi) * (" + w + " - 1) + 0.5, in texels from x of the slice"},
          {"row", "theta_d / pi * (" + h + " - 1) + 0.5, in texels from y of the slice"},
          {"slice", "linear between the two theta_in around the light's, clamped at the ends"}}},
        {"conserved", layout.conserve},
        {"materials", materials}};
    return document.dump(1);
}

}  // namespace kiln::measured
