// SPDX-License-Identifier: Apache-2.0
#include "server/measured/slices.h"

#include <algorithm>
#include <cmath>

#include "server/base/error.h"
#include "server/measured/resample.h"
#include "server/spec/slice_grid.h"

namespace kiln::measured {
namespace {

constexpr float kBelowHorizon = 3;

/// One slice of one material with its gutter.
void fill_cell(const SliceLayout& layout, const LobeTables& tables, double theta_in,
               SlicePlan::Place at, Resampler& resampler, SliceTable& made, SliceAccount& account,
               std::array<std::size_t, 4>& origins) {
    const auto gutter = static_cast<double>(layout.gutter);
    const std::size_t width = made.plan.cell_width, height = made.plan.cell_height;
    std::vector<Vec> out;
    out.reserve(width * height);
    for (std::size_t row = 0; row < height; ++row)
        for (std::size_t column = 0; column < width; ++column)
            out.push_back(view_of(layout, theta_in, static_cast<double>(column) - gutter,
                                  static_cast<double>(row) - gutter));
    const Sampled found = resampler.values(tables, theta_in, out);
    const std::size_t first = (at.y - layout.gutter) * made.plan.width + at.x - layout.gutter;
    for (std::size_t row = 0; row < height; ++row)
        for (std::size_t column = 0; column < width; ++column) {
            const std::size_t from = row * width + column;
            const std::size_t to = first + row * made.plan.width + column;
            const bool inside = row >= layout.gutter && row < height - layout.gutter &&
                                column >= layout.gutter && column < width - layout.gutter;
            std::size_t k = 0;
            for (const std::vector<float>* plane : {&found.r, &found.g, &found.b}) {
                if (!std::isfinite((*plane)[from]))  // which max() would make 0
                    throw Error("non_finite", "the slice at theta_in = " + in_words(theta_in) +
                                                  " has a value that is no finite number; the "
                                                  "file's values are too large to interpolate");
                made.table.planes[k++][to] = std::max(0.0f, (*plane)[from]);
                account.negative += inside && (*plane)[from] < 0;
            }
            const float origin = out[from].z < 0 ? kBelowHorizon : found.origin[from];
            made.table.planes[3][to] = origin;
            if (inside) ++origins[static_cast<std::size_t>(origin)];
        }
}

void fill_account(const SliceLayout& layout, const Material& material, const LobeTables& tables,
                  Resampler& resampler, const std::array<std::size_t, 4>& origins,
                  SliceAccount& account) {
    const auto above = static_cast<double>(origins[0] + origins[1] + origins[2]);
    account.measured = static_cast<double>(origins[0]) / above;
    account.interpolated = static_cast<double>(origins[1]) / above;
    account.extrapolated = static_cast<double>(origins[2]) / above;
    account.albedo = resampler.albedos(tables, layout.theta_in);
    bool told = false;
    const auto tell_of = [&](double theta_in, double albedo) {
        account.warnings.push_back("the albedo at theta_in = " + in_words(theta_in) + " is " +
                                   in_words(albedo) + ": more light leaves than came");
        told = true;
    };
    for (std::size_t s = 0; s < layout.theta_in.size(); ++s) {
        const double theta_in = layout.theta_in[s];
        const Colour& e = account.albedo[s].value;
        const double most = *std::max_element(e.begin(), e.end());
        if (most > 1) tell_of(theta_in, most);
        if (theta_in > material.theta_in_max() + 1e-6)
            account.warnings.push_back("theta_in = " + in_words(theta_in) +
                                       " lies beyond the last measured incidence, " +
                                       in_words(material.theta_in_max()));
    }
    account.average = resampler.average_albedo(tables);
    account.physics = layout.conserve ? physics_of(tables, resampler) : account.measured_physics;
    if (account.physics.albedo_max > 1 && !told)
        tell_of(account.physics.albedo_max_theta_in, account.physics.albedo_max);
}

/// Sums of |look-up - f| cos(theta_o) and of f cos(theta_o) where f was measured.
struct Missed {
    double off = 0, all = 0;
    double relative() const { return all > 0 ? off / all : 0; }
};

/// The golden spiral on the disk of projected solid angle.
std::vector<Vec> even_views() {
    constexpr int kViews = 2048;
    std::vector<Vec> views;
    for (int n = 0; n < kViews; ++n) {
        const double r2 = (n + 0.5) / kViews, turn = 360 * 0.6180339887498949 * n;
        views.push_back(direction(std::asin(std::sqrt(r2)) / kDegree, turn));
    }
    return views;
}

/// What the table's own linear steps between incidences that were not measured lose: a sixth of how
/// far each is from the mean of its neighbours.
double steps_error(const LobeTables& tables, Resampler& resampler) {
    if (tables.measured.size() == tables.theta_in.size()) return 0;
    Missed sum;
    for (std::size_t s = 1; s + 1 < tables.theta_in.size(); ++s) {
        const double low = tables.theta_in[s - 1], at = tables.theta_in[s],
                     high = tables.theta_in[s + 1];
        std::vector<Vec> before, here, after;
        for (const Vec& out : even_views()) {
            const Vec d = to_mirror(at, out);
            const Vec first = from_mirror(low, d), last = from_mirror(high, d);
            if (first.z < 0 || last.z < 0) continue;
            before.push_back(first), here.push_back(out), after.push_back(last);
        }
        const Sampled a = resampler.values(tables, low, before),
                      f = resampler.values(tables, at, here),
                      b = resampler.values(tables, high, after);
        const double share = (at - low) / (high - low);
        for (std::size_t n = 0; n < here.size(); ++n) {
            if (std::max({a.origin[n], f.origin[n], b.origin[n]}) > 1.5f) continue;
            const double middle = static_cast<double>(f.g[n]);
            sum.off += std::abs((1 - share) * static_cast<double>(a.g[n]) +
                                share * static_cast<double>(b.g[n]) - middle);
            sum.all += std::abs(middle);
        }
    }
    return sum.relative() / 6;
}

Missed missed(const SliceLayout& layout, const SliceTable& made, std::size_t material,
              const LobeTables& tables, double theta_in, Resampler& resampler) {
    const std::vector<Vec> views = even_views();
    const Sampled found = resampler.values(tables, theta_in, views);
    Missed sum;
    for (std::size_t n = 0; n < views.size(); ++n) {
        if (found.origin[n] > 1.5f) continue;
        const Colour c = look_up(layout, made, material, theta_in, views[n]);
        const Colour f = {found.r[n], found.g[n], found.b[n]};
        for (std::size_t k = 0; k < 3; ++k) {
            sum.off += std::abs(c[k] - std::max(0.0, f[k]));
            sum.all += std::max(0.0, f[k]);
        }
    }
    return sum;
}

/// What a shader misses: at slices by the way among texels, between them by that among slices too,
/// of which the middle has half again as much as the mean.
void predict_table(const SliceLayout& layout, const SliceTable& made, std::size_t material,
                   const LobeTables& tables, Resampler& resampler, PredictedError& predicted) {
    const std::vector<double>& angles = layout.theta_in;
    for (const double theta_in : angles)
        predicted.table += missed(layout, made, material, tables, theta_in, resampler).relative() /
                           static_cast<double>(angles.size());
    double between = 0, width = 0;
    for (std::size_t n = 0; n + 1 < angles.size(); ++n) {
        const double middle = 0.5 * (angles[n] + angles[n + 1]), gap = angles[n + 1] - angles[n];
        const Missed there = missed(layout, made, material, tables, middle, resampler);
        if (there.all <= 0) continue;
        between += gap * there.relative();
        width += gap;
    }
    if (predicted.knows_theta_in) predicted.theta_in += steps_error(tables, resampler);
    if (width > 0) predicted.slices = std::max(0.0, between / width - predicted.table) * 2 / 3;
}

}  // namespace

Vec view_of(const SliceLayout& layout, double theta_in, double column, double row) {
    const double phi = 360.0 * column / static_cast<double>(layout.width - 1);
    const double theta =
        std::clamp(180.0 * row / static_cast<double>(layout.height - 1), 0.0, 180.0);
    const Vec d = direction(theta, phi);
    return from_mirror(theta_in, d);
}

SlicePlan plan_slices(const SliceLayout& layout, std::size_t material_count) {
    const SliceGrid grid = slice_grid(layout.width, layout.height, layout.gutter,
                                      layout.theta_in.size(), material_count);
    if (const auto why = too_large(grid)) throw Error("too_large", "the image " + *why);
    SlicePlan plan;
    plan.cell_width = grid.cell_width;
    plan.cell_height = grid.cell_height;
    plan.slice_columns = grid.slice_columns;
    plan.cell_columns = grid.cell_columns;
    plan.cell_rows = grid.cell_rows;
    plan.width = grid.width();
    plan.height = grid.height();
    return plan;
}

SlicePlan::Place SlicePlan::place(const SliceLayout& layout, std::size_t slice,
                                  std::size_t material) const {
    const SliceGrid grid{.slice_columns = slice_columns,
                         .cell_columns = cell_columns,
                         .cell_rows = cell_rows,
                         .cell_width = cell_width,
                         .cell_height = cell_height};
    const SliceGrid::Place at = grid.place(slice, material, layout.gutter);
    return {at.x, at.y};
}

SliceTable make_slices(const SliceLayout& layout, const std::vector<const Material*>& materials,
                       const std::function<void(double)>& tell, Backend* backend) {
    Resampler resampler(backend);
    SliceTable made;
    made.plan = plan_slices(layout, materials.size());
    made.table.width = made.plan.width;
    made.table.height = made.plan.height;
    made.table.channels = {"R", "G", "B", "origin"};
    made.table.planes.assign(4, std::vector<float>(made.plan.width * made.plan.height));
    const auto count = static_cast<double>(materials.size());
    // Integrals and the figures of the account take as long as a slice or two.
    const auto slices = static_cast<double>(layout.theta_in.size() + 2);
    for (std::size_t m = 0; m < materials.size(); ++m) {
        SliceAccount account;
        std::array<std::size_t, 4> origins{};
        LobeTables tables = make_lobe_tables(*materials[m]);
        account.measured_physics = physics_of(tables, resampler);
        if (layout.conserve) conserve(tables, resampler);
        for (std::size_t s = 0; s < layout.theta_in.size(); ++s) {
            tell((static_cast<double>(m) + static_cast<double>(s) / slices) / count);
            fill_cell(layout, tables, layout.theta_in[s], made.plan.place(layout, s, m), resampler,
                      made, account, origins);
        }
        fill_account(layout, *materials[m], tables, resampler, origins, account);
        account.predicted = predict_error(*materials[m]);
        account.between = materials[m]->between();
        account.gaps = theta_in_errors(*materials[m]);
        account.incidences = materials[m]->theta_in();
        predict_table(layout, made, m, tables, resampler, account.predicted);
        made.accounts.push_back(std::move(account));
    }
    return made;
}

Colour look_up(const SliceLayout& layout, const SliceTable& made, std::size_t material,
               double theta_in, Vec out) {
    const Vec d = to_mirror(theta_in, out);
    const double x = wrapped_degrees(phi_of(d)) / 360 * static_cast<double>(layout.width - 1);
    const double y = theta_of(d) / 180 * static_cast<double>(layout.height - 1);
    const auto& angles = layout.theta_in;
    const auto above = std::upper_bound(angles.begin(), angles.end(), theta_in);
    const std::size_t low =
        above == angles.begin() ? 0 : static_cast<std::size_t>(above - angles.begin()) - 1;
    const std::size_t high = std::min(low + 1, angles.size() - 1);
    const double w =
        high > low ? std::clamp((theta_in - angles[low]) / (angles[high] - angles[low]), 0.0, 1.0)
                   : 0.0;
    const auto column = std::min(static_cast<std::size_t>(x), layout.width - 2);
    const auto row = std::min(static_cast<std::size_t>(y), layout.height - 2);
    const double u = x - static_cast<double>(column), v = y - static_cast<double>(row);
    Colour result{};
    for (const auto& [slice, share] : {std::pair(low, 1 - w), std::pair(high, w)}) {
        const SlicePlan::Place at = made.plan.place(layout, slice, material);
        const std::size_t n = (at.y + row) * made.plan.width + at.x + column;
        for (std::size_t k = 0; k < 3; ++k) {
            const std::vector<float>& plane = made.table.planes[k];
            result[k] +=
                share *
                ((1 - v) * ((1 - u) * plane[n] + u * plane[n + 1]) +
                 v * ((1 - u) * plane[n + made.plan.width] + u * plane[n + made.plan.width + 1]));
        }
    }
    return result;
}

}  // namespace kiln::measured
