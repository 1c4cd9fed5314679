// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <optional>
#include <string>

#include "server/spec/job_spec.h"

namespace kiln {

/// Where slices and materials lie in one image. Slices follow each other in rows, as near to a
/// square as they come; each is a grid of cells, one a material, laid out by the same rule. A cell
/// is a slice of one material with its gutter.
struct SliceGrid {
    std::size_t slice_columns = 0, slice_rows = 0, cell_columns = 0, cell_rows = 0;
    std::size_t cell_width = 0, cell_height = 0;
    std::size_t width() const { return slice_columns * cell_columns * cell_width; }
    std::size_t height() const { return slice_rows * cell_rows * cell_height; }

    struct Place {
        std::size_t x = 0, y = 0;  ///< of the first texel inside the gutter
    };
    Place place(std::size_t slice, std::size_t cell, std::size_t gutter) const;
};

/// Of slices of width x height texels.
SliceGrid slice_grid(std::size_t width, std::size_t height, std::size_t gutter,
                     std::size_t slice_count, std::size_t material_count);

/// Of a job of measured kind: pictures are cells of one slice; a companion is a row a material.
SliceGrid slice_grid(const JobSpec& job);

/// Why an image of that grid is not made, as the end of "the image …"; empty where it is.
std::optional<std::string> too_large(const SliceGrid& grid);

}  // namespace kiln
