// SPDX-License-Identifier: Apache-2.0
#include "server/compute/axes.h"

namespace kiln {

std::size_t roughness_axis(const JobSpec& job) {
    std::size_t axis = 0;
    while (job.axes.at(axis).parameter == Parameter::NoV) ++axis;
    return axis;
}

namespace {
std::vector<double> values_along(const JobSpec& job, std::size_t axis) {
    std::vector<double> values;
    for (std::int64_t i = 0; i < job.resolution[axis]; ++i) {
        const double value = axis_value(job.axes[axis], i, job.resolution[axis]);
        const bool rough = job.axes[axis].parameter == Parameter::roughness;
        values.push_back(rough ? alpha_from_roughness(value) : value);
    }
    return values;
}
}  // namespace

Places Places::directional(const JobSpec& job) {
    const std::size_t rough = roughness_axis(job), view = 1 - rough;
    Places places;
    places.width_ = static_cast<std::size_t>(job.resolution[0]);
    places.height_ = static_cast<std::size_t>(job.resolution[1]);
    places.NoV_along_x_ = view == 0;
    places.NoV_ = values_along(job, view);
    places.alpha_ = values_along(job, rough);
    return places;
}

Places Places::averaged(const JobSpec& job) {
    Places places;
    places.alpha_ = values_along(job, roughness_axis(job));
    places.height_ = places.alpha_.size();
    return places;
}

double Places::NoV(std::size_t place) const {
    if (NoV_.empty()) return 0;
    return NoV_[NoV_along_x_ ? place % width_ : place / width_];
}

double Places::alpha(std::size_t place) const { return alpha_[averaged_place(place)]; }

std::size_t Places::averaged_place(std::size_t place) const {
    if (NoV_.empty()) return place;
    return NoV_along_x_ ? place / width_ : place % width_;
}

}  // namespace kiln
