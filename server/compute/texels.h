// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <cstddef>
#include <functional>
#include <vector>

#include "server/compute/axes.h"

namespace kiln {

/// Where a place lies in the table: slices of [x, y] one below the other.
class Texels {
  public:
    explicit Texels(const JobSpec& job)
        : width_(extent(job, 0)),
          slice_height_(extent(job, 1)),
          slice_count_(extent(job, 2)),
          rough_along_x_(roughness_axis(job) == 0) {}

    std::size_t width() const { return width_; }
    std::size_t height() const { return slice_height_ * slice_count_; }

    /// Calls body(texel) for the texels of a slice that one place fills: an averaged place fills
    /// its whole line.
    template <typename Body>
    void each(bool averaged, std::size_t slice, std::size_t place, Body body) const {
        const std::size_t above = slice * slice_height_ * width_;
        if (!averaged) {
            body(above + place);
        } else if (rough_along_x_) {
            for (std::size_t y = 0; y < slice_height_; ++y) body(above + y * width_ + place);
        } else {
            for (std::size_t x = 0; x < width_; ++x) body(above + place * width_ + x);
        }
    }

    /// One value a slice.
    void fill(std::vector<float>& plane, const std::function<double(std::size_t)>& value) const {
        const std::size_t texels = slice_height_ * width_;
        for (std::size_t slice = 0; slice < slice_count_; ++slice)
            std::fill_n(plane.begin() + static_cast<std::ptrdiff_t>(slice * texels), texels,
                        static_cast<float>(value(slice)));
    }

  private:
    static std::size_t extent(const JobSpec& job, std::size_t axis) {
        return axis < job.resolution.size() ? static_cast<std::size_t>(job.resolution[axis]) : 1;
    }
    std::size_t width_, slice_height_, slice_count_;
    bool rough_along_x_;
};

}  // namespace kiln
