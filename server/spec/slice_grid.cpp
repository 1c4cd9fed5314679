// SPDX-License-Identifier: Apache-2.0
#include "server/spec/slice_grid.h"

#include <algorithm>

#include "server/spec/kinds.h"
#include "server/spec/limits.h"

namespace kiln {

namespace {
std::size_t columns_for(std::size_t count) {
    std::size_t columns = 1;
    while (columns * columns < count) ++columns;
    return columns;
}
}  // namespace

SliceGrid slice_grid(std::size_t width, std::size_t height, std::size_t gutter,
                     std::size_t slice_count, std::size_t material_count) {
    SliceGrid grid;
    grid.slice_columns = columns_for(slice_count);
    grid.slice_rows = (slice_count + grid.slice_columns - 1) / grid.slice_columns;
    grid.cell_columns = columns_for(material_count);
    grid.cell_rows = (material_count + grid.cell_columns - 1) / grid.cell_columns;
    grid.cell_width = width + 2 * gutter;
    grid.cell_height = height + 2 * gutter;
    return grid;
}

SliceGrid slice_grid(const JobSpec& job) {
    const auto size = [](std::int64_t n) { return static_cast<std::size_t>(n); };
    const std::size_t materials = job.measured.materials.size();
    if (job.kind == Kind::companion)
        return {.slice_columns = 1,
                .slice_rows = 1,
                .cell_columns = 1,
                .cell_rows = materials,
                .cell_width = size(job.resolution[0]),
                .cell_height = 1};
    const std::size_t slices = is_view(job.kind) ? 1 : job.measured.theta_in.size();
    return slice_grid(size(job.resolution[0]), size(job.resolution[1]), size(job.measured.gutter),
                      slices, materials);
}

SliceGrid::Place SliceGrid::place(std::size_t slice, std::size_t cell, std::size_t gutter) const {
    const std::size_t column = slice % slice_columns * cell_columns + cell % cell_columns;
    const std::size_t row = slice / slice_columns * cell_rows + cell / cell_columns;
    return {column * cell_width + gutter, row * cell_height + gutter};
}

std::optional<std::string> too_large(const SliceGrid& grid) {
    const auto side_max = static_cast<std::size_t>(limits().atlas_side_max);
    const auto texels_max = static_cast<std::size_t>(limits().atlas_texels_max);
    const std::size_t width = grid.width(), height = grid.height();
    if (std::max(width, height) <= side_max && width * height <= texels_max) return {};
    return "would have " + std::to_string(width) + " x " + std::to_string(height) +
           " texels; at most " + std::to_string(side_max) + " on a side and " +
           std::to_string(texels_max) + " in all are made";
}

}  // namespace kiln
