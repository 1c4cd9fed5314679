// SPDX-License-Identifier: Apache-2.0
#include "server/measured/atlas.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace kiln::measured {
namespace {

/// Copies each cell, with its gutter, from an image of one material into that of many.
void paste(const SliceLayout& layout, const SliceTable& one, std::size_t material,
           SliceTable& all) {
    for (std::size_t s = 0; s < layout.theta_in.size(); ++s) {
        const SlicePlan::Place from = one.plan.place(layout, s, 0),
                               to = all.plan.place(layout, s, material);
        for (std::size_t row = 0; row < all.plan.cell_height; ++row)
            for (std::size_t k = 0; k < all.table.planes.size(); ++k) {
                const auto source =
                    one.table.planes[k].begin() +
                    static_cast<std::ptrdiff_t>((from.y - layout.gutter + row) * one.plan.width +
                                                from.x - layout.gutter);
                std::copy_n(
                    source, all.plan.cell_width,
                    all.table.planes[k].begin() +
                        static_cast<std::ptrdiff_t>((to.y - layout.gutter + row) * all.plan.width +
                                                    to.x - layout.gutter));
            }
    }
}

}  // namespace

Atlas::Atlas(SliceLayout layout, std::size_t material_count, Backend* backend)
    : layout_(std::move(layout)), backend_(backend) {
    made_.plan = plan_slices(layout_, material_count);
    Table& table = made_.table;
    table.width = made_.plan.width;
    table.height = made_.plan.height;
    table.channels = {"R", "G", "B", "origin"};
    // Cells that no material takes are below every horizon.
    table.planes.assign(4, std::vector<float>(table.width * table.height));
    std::fill(table.planes[3].begin(), table.planes[3].end(), 3.0F);
}

void Atlas::add(const Material& material, const std::function<void(double)>& tell) {
    SliceTable one = make_slices(layout_, {&material}, tell, backend_);
    paste(layout_, one, made_.accounts.size(), made_);
    made_.accounts.push_back(std::move(one.accounts.front()));
}

double lookup_error(const SliceLayout& layout, const SliceTable& made, std::size_t material,
                    std::size_t slice, const Material& truth) {
    constexpr std::size_t kColumns = 72, kRows = 60;
    constexpr double kThetaOutMost = 75;
    const std::size_t column_step = std::max<std::size_t>(1, (layout.width - 1) / kColumns);
    const std::size_t row_step = std::max<std::size_t>(1, (layout.height - 1) / kRows);
    const double theta_in = layout.theta_in[slice];
    double off = 0, all = 0;
    for (std::size_t row = 0; row + 1 < layout.height; row += row_step)
        for (std::size_t column = 0; column + 1 < layout.width; column += column_step) {
            const Vec out = view_of(layout, theta_in, static_cast<double>(column) + 0.5,
                                    static_cast<double>(row) + 0.5);
            if (theta_of(out) > kThetaOutMost) continue;
            const double theta_d = std::numbers::pi * (static_cast<double>(row) + 0.5) /
                                   static_cast<double>(layout.height - 1);
            const double weight = std::sin(theta_d) * out.z;
            Origin origin{};
            const double f = truth.value(theta_in, out, origin)[1];
            off += weight *
                   std::abs(look_up(layout, made, material, theta_in, out)[1] - std::max(0.0, f));
            all += weight * std::max(0.0, f);
        }
    return all > 0 ? off / all : 0;
}

}  // namespace kiln::measured
