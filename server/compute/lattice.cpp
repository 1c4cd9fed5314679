// SPDX-License-Identifier: Apache-2.0
#include "server/compute/lattice.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "server/compute/axes.h"

namespace kiln {

namespace {

/// Below these a lookup is not judged: any table is as wrong as the lobe is deep where NoV and
/// alpha vanish together, at whatever size.
constexpr double kLeast = 1e-4;

double least_of(Parameter parameter) {
    switch (parameter) {
        case Parameter::NoV:
        case Parameter::alpha:
            return kLeast;
        case Parameter::roughness:
            return std::sqrt(kLeast);
        case Parameter::f0:
        case Parameter::ior:
            return 0;
    }
    __builtin_unreachable();
}

/// The position between two texels at which the parameter is `value`, by bisection.
double position_of(const Axis& axis, std::int64_t count, double low, double high, double value) {
    const bool rising =
        axis_value_between(axis, high, count) > axis_value_between(axis, low, count);
    for (int step = 0; step < 60; ++step) {
        const double middle = (low + high) / 2;
        ((axis_value_between(axis, middle, count) < value) == rising ? low : high) = middle;
    }
    return rising ? high : low;
}

}  // namespace

std::vector<std::int64_t> ladder(std::int64_t count, bool flip, double growth) {
    std::set<std::int64_t> texels;
    const auto add = [&](bool from_start, double factor) {
        double at = 0;
        while (at < static_cast<double>(count)) {
            const auto i = static_cast<std::int64_t>(at);
            texels.insert(from_start ? i : count - 1 - i);
            at = std::max(std::floor(at) + 1, at * factor);
        }
    };
    add(!flip, growth);
    add(flip, growth * growth);
    return {texels.begin(), texels.end()};
}

Lattice::Line Lattice::line(const Axis& axis, std::int64_t count, double growth) {
    Line line;
    line.count = count;
    const std::vector<std::int64_t> texels = ladder(count, axis.flip, growth);
    std::set<std::int64_t> corners;
    std::set<double> places;
    const double least = least_of(axis.parameter);
    const auto inside = [&](double at) { return axis_value_between(axis, at, count) >= least; };
    const auto last = static_cast<double>(count - 1);
    // From one texel (or rim) to the next: the place between, or where the parameter is the least.
    const auto look_up = [&](double low, double high, double middle) {
        if (inside(low) != inside(high)) {
            const double rim = position_of(axis, count, low, high, least);
            places.insert({rim, (rim + (inside(low) ? low : high)) / 2});
        } else if (inside(middle)) {
            places.insert(middle);
        }
    };
    for (const std::int64_t i : texels) {
        corners.insert(i);
        if (i + 1 == count) continue;
        corners.insert(i + 1);
        const auto at = static_cast<double>(i);
        look_up(at, at + 1, at + 0.5);
    }
    if (axis.grid == Grid::center) {
        look_up(-0.5, 0, -0.5);
        look_up(last, last + 0.5, last + 0.5);
    }
    for (const std::int64_t i : corners) places.insert(static_cast<double>(i));
    line.at.assign(places.begin(), places.end());
    for (const double at : line.at) {
        const double held = std::clamp(at, 0.0, last), low = std::floor(held);
        const auto find = [&](double texel) {
            return static_cast<std::size_t>(
                std::lower_bound(line.at.begin(), line.at.end(), texel) - line.at.begin());
        };
        line.low.push_back(find(low));
        line.high.push_back(find(std::min(low + 1, last)));
        line.share.push_back(held - low);
        line.looked_up.push_back(inside(at));
        line.weight.push_back(0);
    }
    for (const std::int64_t i : corners) {
        const auto next = corners.upper_bound(i);
        const auto here = corners.find(i);
        const double above =
            next == corners.end() ? last + 0.5 : static_cast<double>(i + *next) / 2;
        const double below =
            here == corners.begin() ? -0.5 : static_cast<double>(i + *std::prev(here)) / 2;
        line.weight[static_cast<std::size_t>(
            std::lower_bound(line.at.begin(), line.at.end(), static_cast<double>(i)) -
            line.at.begin())] = above - below;
    }
    return line;
}

Lattice::Lattice(const JobSpec& job, double growth) : lattice_(job) {
    // Along z, Fresnel's number is smooth, and each of its slices costs a table.
    const double growths[] = {growth, growth, 8};
    for (std::size_t a = 0; a < 3; ++a) {
        if (a >= job.axes.size()) {
            lines_[a] = {{0}, {true}, {0}, {0}, {0}, {1}, 1};
            continue;
        }
        lines_[a] = line(job.axes[a], job.resolution[a], growths[a]);
        lattice_.axes[a].at = lines_[a].at;
        lattice_.axes[a].of = job.resolution[a];
        lattice_.resolution[a] = static_cast<std::int64_t>(lines_[a].at.size());
    }
}

std::size_t Lattice::index(const std::array<std::size_t, 3>& at) const {
    return (at[2] * lines_[1].at.size() + at[1]) * lines_[0].at.size() + at[0];
}

std::size_t Lattice::place_count() const {
    return lines_[0].at.size() * lines_[1].at.size() * lines_[2].at.size();
}

void Lattice::each_texel(const std::function<void(std::size_t, std::size_t, double)>& body) const {
    const auto& [x, y, z] = lines_;
    const auto texel = [](const Line& line, std::size_t i) {
        return static_cast<std::size_t>(line.at[i]);
    };
    for (std::size_t k = 0; k < z.at.size(); ++k)
        for (std::size_t j = 0; j < y.at.size(); ++j)
            for (std::size_t i = 0; i < x.at.size(); ++i) {
                const double weight = x.weight[i] * y.weight[j] * z.weight[k];
                if (weight == 0) continue;
                const std::size_t row =
                    texel(z, k) * static_cast<std::size_t>(y.count) + texel(y, j);
                body(index({i, j, k}), row * static_cast<std::size_t>(x.count) + texel(x, i),
                     weight);
            }
}

double Lattice::reconstruction_max(const std::vector<float>& exact) const {
    const auto& [x, y, z] = lines_;
    const auto mix = [](double low, double high, double share) {
        return low + (high - low) * share;
    };
    double most = 0;
    for (std::size_t k = 0; k < z.at.size(); ++k)
        for (std::size_t j = 0; j < y.at.size(); ++j)
            for (std::size_t i = 0; i < x.at.size(); ++i) {
                if (!x.looked_up[i] || !y.looked_up[j] || !z.looked_up[k]) continue;
                const auto along_x = [&](std::size_t row, std::size_t slice) {
                    return mix(exact[index({x.low[i], row, slice})],
                               exact[index({x.high[i], row, slice})], x.share[i]);
                };
                const auto along_y = [&](std::size_t slice) {
                    return mix(along_x(y.low[j], slice), along_x(y.high[j], slice), y.share[j]);
                };
                const double found = mix(along_y(z.low[k]), along_y(z.high[k]), z.share[k]);
                most = std::max(most, std::abs(found - exact[index({i, j, k})]));
            }
    return most;
}

double estimated_reconstruction_max(const JobSpec& job, const std::vector<float>& plane) {
    std::array<std::size_t, 3> extent{1, 1, 1}, stride{1, 1, 1};
    for (std::size_t a = 0; a < job.resolution.size(); ++a)
        extent[a] = static_cast<std::size_t>(job.resolution[a]);
    stride[1] = extent[0];
    stride[2] = extent[0] * extent[1];
    double most = 0;
    for (std::size_t i = 0; i < plane.size(); ++i) {
        double sum = 0;
        for (std::size_t a = 0; a < 3; ++a) {
            const std::size_t at = i / stride[a] % extent[a];
            if (at == 0 || at + 1 == extent[a]) continue;
            const double around = static_cast<double>(plane[i - stride[a]]) + plane[i + stride[a]];
            sum += std::abs(around - 2.0 * plane[i]) / 8;
        }
        most = std::max(most, sum);
    }
    return most;
}

}  // namespace kiln
