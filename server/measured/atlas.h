// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "server/measured/slices.h"

namespace kiln::measured {

/// An image of slices that is made material by material, so that only one is held at a time.
class Atlas {
  public:
    /// `backend` as for make_slices; it outlives this.
    Atlas(SliceLayout layout, std::size_t material_count, Backend* backend = nullptr);
    /// The next material, in the order of cells. `tell` as for make_slices.
    void add(const Material& material, const std::function<void(double fraction)>& tell);
    const SliceLayout& layout() const { return layout_; }
    const SliceTable& made() const { return made_; }

  private:
    SliceLayout layout_;
    Backend* backend_;
    SliceTable made_;
};

/// What lookup between texels adds to a material's slice: integral of |look_up() - f| cos over the
/// view, by that of f cos, of green (or the only channel). Views are those halfway between texels,
/// some thousand of them, where theta_out is at most 75 degrees: nearer to the horizon texels below
/// it take part.
double lookup_error(const SliceLayout& layout, const SliceTable& made, std::size_t material,
                    std::size_t slice, const Material& truth);

}  // namespace kiln::measured
