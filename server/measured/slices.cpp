// SPDX-License-Identifier: Apache-2.0
#include "server/measured/slices.h"

#include <algorithm>
#include <cmath>

#include "server/base/error.h"
#include "server/spec/slice_grid.h"

namespace kiln::measured {
namespace {

constexpr float kBelowHorizon = 3;

/// One slice of one material with its gutter.
void fill_cell(const SliceLayout& layout, const Material& material, double theta_in,
               SlicePlan::Place at, SliceTable& made, SliceAccount& account,
               std::array<std::size_t, 4>& origins, const std::function<void()>& between_rows) {
    const auto gutter = static_cast<std::ptrdiff_t>(layout.gutter);
    const auto width = static_cast<std::ptrdiff_t>(layout.width);
    const auto height = static_cast<std::ptrdiff_t>(layout.height);
    for (std::ptrdiff_t row = -gutter; row < height + gutter; ++row) {
        between_rows();
        for (std::ptrdiff_t column = -gutter; column < width + gutter; ++column) {
            const Vec out =
                view_of(layout, theta_in, static_cast<double>(column), static_cast<double>(row));
            Origin origin{};
            const Colour f = material.value(theta_in, out, origin);
            const std::size_t n =
                static_cast<std::size_t>(static_cast<std::ptrdiff_t>(at.y) + row) *
                    made.plan.width +
                static_cast<std::size_t>(static_cast<std::ptrdiff_t>(at.x) + column);
            const bool inside = row >= 0 && row < height && column >= 0 && column < width;
            for (std::size_t k = 0; k < 3; ++k) {
                made.table.planes[k][n] = static_cast<float>(std::max(0.0, f[k]));
                account.negative += inside && f[k] < 0;
            }
            made.table.planes[3][n] = out.z < 0 ? kBelowHorizon : static_cast<float>(origin);
            if (inside) ++origins[out.z < 0 ? 3 : static_cast<std::size_t>(origin)];
        }
    }
}

void fill_account(const SliceLayout& layout, const Material& material,
                  const std::array<std::size_t, 4>& origins, SliceAccount& account) {
    const auto above = static_cast<double>(origins[0] + origins[1] + origins[2]);
    account.measured = static_cast<double>(origins[0]) / above;
    account.interpolated = static_cast<double>(origins[1]) / above;
    account.extrapolated = static_cast<double>(origins[2]) / above;
    for (const double theta_in : layout.theta_in) {
        account.albedo.push_back(material.albedo(theta_in));
        const Colour& e = account.albedo.back().value;
        if (*std::max_element(e.begin(), e.end()) > 1)
            account.warnings.push_back("the albedo at theta_in = " + in_words(theta_in) + " is " +
                                       in_words(*std::max_element(e.begin(), e.end())) +
                                       ": more light leaves than came");
        if (theta_in > material.theta_in_max() + 1e-6)
            account.warnings.push_back("theta_in = " + in_words(theta_in) +
                                       " lies beyond the last measured incidence, " +
                                       in_words(material.theta_in_max()));
    }
    account.average = material.average_albedo();
}

}  // namespace

Vec view_of(const SliceLayout& layout, double theta_in, double column, double row) {
    const double phi = 360.0 * column / static_cast<double>(layout.width - 1);
    const double theta =
        std::clamp(180.0 * row / static_cast<double>(layout.height - 1), 0.0, 180.0);
    const Vec d = direction(theta, phi);
    const double c = std::cos(theta_in * kDegree), s = std::sin(theta_in * kDegree);
    return {-c * d.x - s * d.z, -d.y, -s * d.x + c * d.z};  // Cezner 2024, equation 15
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
    const std::size_t column = slice % slice_columns * cell_columns + material % cell_columns;
    const std::size_t row = slice / slice_columns * cell_rows + material / cell_columns;
    return {column * cell_width + layout.gutter, row * cell_height + layout.gutter};
}

SliceTable make_slices(const SliceLayout& layout, const std::vector<const Material*>& materials,
                       const std::function<void(double)>& tell) {
    SliceTable made;
    made.plan = plan_slices(layout, materials.size());
    made.table.width = made.plan.width;
    made.table.height = made.plan.height;
    made.table.channels = {"R", "G", "B", "origin"};
    made.table.planes.assign(4, std::vector<float>(made.plan.width * made.plan.height));
    const std::size_t rows =
        materials.size() * layout.theta_in.size() * (layout.height + 2 * layout.gutter);
    std::size_t done = 0;
    const auto between_rows = [&] {
        tell(static_cast<double>(done++) / static_cast<double>(rows));
    };
    for (std::size_t m = 0; m < materials.size(); ++m) {
        SliceAccount account;
        std::array<std::size_t, 4> origins{};
        for (std::size_t s = 0; s < layout.theta_in.size(); ++s)
            fill_cell(layout, *materials[m], layout.theta_in[s], made.plan.place(layout, s, m),
                      made, account, origins, between_rows);
        fill_account(layout, *materials[m], origins, account);
        made.accounts.push_back(std::move(account));
    }
    return made;
}

Colour look_up(const SliceLayout& layout, const SliceTable& made, std::size_t material,
               double theta_in, Vec out) {
    const double c = std::cos(theta_in * kDegree), s = std::sin(theta_in * kDegree);
    const Vec d = {-c * out.x - s * out.z, -out.y, -s * out.x + c * out.z};
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
