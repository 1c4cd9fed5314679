// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "server/spec/job_spec.h"

namespace kiln {

/// Where texel `index` of `count` lies on an axis: the parameter's value. Centres lie at (i + ½) /
/// n of the axis, nodes at i / (n − 1) (a single node at 0). The one place that knows grid, mapping
/// and flip.
double axis_value(const Axis& axis, std::int64_t index, std::int64_t count);
/// The same between texels: lookup at this distance, in texels, from the first one.
double axis_value_between(const Axis& axis, double texel, std::int64_t count);

/// alpha = roughness². The one place that knows the mapping.
inline double alpha_from_roughness(double roughness) { return roughness * roughness; }

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
