// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "server/spec/axis_value.h"
#include "server/spec/job_spec.h"

namespace kiln {

/// Index of the axis that carries roughness or alpha.
std::size_t roughness_axis(const JobSpec& job);

/// The places that one pass over a job integrates: every texel, row-major, or (averaged) one place
/// for each position of the roughness axis, at which NoV is 0 and unused.
class Places {
  public:
    static Places directional(const JobSpec& job);
    static Places averaged(const JobSpec& job);

    std::size_t count() const { return width_ * height_; }
    double NoV(std::size_t place) const;
    double alpha(std::size_t place) const;
    /// The place of averaged() that has the same roughness.
    std::size_t averaged_place(std::size_t place) const;

  private:
    std::size_t width_ = 1, height_ = 1;
    bool NoV_along_x_ = true;
    std::vector<double> NoV_, alpha_;  // along their axes; NoV_ empty when averaged
};

}  // namespace kiln
