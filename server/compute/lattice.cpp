// SPDX-License-Identifier: Apache-2.0
#include "server/compute/lattice.h"

#include <algorithm>
#include <cmath>
#include <optional>
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

Lattice::Line Lattice::line(const Axis& axis, std::int64_t count, double growth, int parts) {
    Line line;
    line.count = count;
    const std::vector<std::int64_t> texels = ladder(count, axis.flip, growth);
    std::set<std::int64_t> corners;
    std::set<double> places;
    const double least = least_of(axis.parameter);
    const auto inside = [&](double at) { return axis_value_between(axis, at, count) >= least; };
    const auto last = static_cast<double>(count - 1);
    // From one texel (or rim) to the next, or where the parameter is the least.
    const auto look_up = [&](double low, double high) {
        if (inside(low) != inside(high)) {
            const double rim = position_of(axis, count, low, high, least);
            places.insert(rim);
            (inside(low) ? high : low) = rim;
        }
        for (int part = 1; part < parts; ++part) {
            const double at = low + (high - low) * part / parts;
            if (inside(at)) places.insert(at);
        }
    };
    // Beyond the last centre the lookup stays what it is, and the rim is furthest from it.
    const auto look_up_rim = [&](double centre, double rim) {
        if (inside(rim))
            places.insert(rim);
        else if (inside(centre))
            places.insert(
                position_of(axis, count, std::min(centre, rim), std::max(centre, rim), least));
    };
    for (const std::int64_t i : texels) {
        corners.insert(i);
        if (i + 1 == count) continue;
        corners.insert(i + 1);
        const auto at = static_cast<double>(i);
        look_up(at, at + 1);
    }
    if (axis.grid == Grid::center) {
        look_up_rim(0, -0.5);
        look_up_rim(last, last + 0.5);
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
    find_neighbours(line);
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

Lattice::Lattice(const JobSpec& job, double growth, int parts) : lattice_(job) {
    // Along z, Fresnel's number is smooth, and each of its slices costs a table.
    const double growths[] = {growth, growth, 8};
    for (std::size_t a = 0; a < 3; ++a) {
        if (a >= job.axes.size()) {
            lines_[a] = {{0}, {true}, {0}, {0}, {0}, {1}, 1, {{0, 0}}, {{0, 0}}};
            continue;
        }
        lines_[a] = line(job.axes[a], job.resolution[a], growths[a], parts);
        lattice_.axes[a].at = lines_[a].at;
        lattice_.axes[a].of = job.resolution[a];
        lattice_.resolution[a] = static_cast<std::int64_t>(lines_[a].at.size());
    }
}

void Lattice::find_neighbours(Line& line) {
    const auto place = [&](double at) -> std::optional<std::size_t> {
        const auto found = std::lower_bound(line.at.begin(), line.at.end(), at);
        if (found == line.at.end() || *found != at) return {};
        const auto index = static_cast<std::size_t>(found - line.at.begin());
        return line.looked_up[index] ? std::optional(index) : std::nullopt;
    };
    for (std::size_t i = 0; i < line.at.size(); ++i) {
        auto &inner = line.inner.emplace_back(std::array{i, i}), &outer = line.outer.emplace_back();
        outer = inner;
        if (!(line.share[i] > 0) || i == 0 || i + 1 == line.at.size()) continue;
        if (line.looked_up[i - 1] && line.looked_up[i + 1]) inner = {i - 1, i + 1};
        // The next place with the same share, which is a multiple of a power of two.
        std::optional<std::size_t> before, after;
        for (std::size_t j = i; j-- > 0 && !before;)
            if (line.share[j] == line.share[i]) before = place(line.at[j]);
        for (std::size_t j = i + 1; j < line.at.size() && !after; ++j)
            if (line.share[j] == line.share[i]) after = place(line.at[j]);
        const bool skipped = before && after && line.at[*after] - line.at[*before] > 2;
        if (skipped) outer = {*before, *after};
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

Lattice Lattice::dense(const JobSpec& job) { return Lattice(job, 1.05, 4); }

std::vector<double> Lattice::differences(const std::vector<float>& exact) const {
    const auto& [x, y, z] = lines_;
    const auto mix = [](double low, double high, double share) {
        return low + (high - low) * share;
    };
    std::vector<double> found(place_count());
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
                const std::size_t at = index({i, j, k});
                found[at] = mix(along_y(z.low[k]), along_y(z.high[k]), z.share[k]) - exact[at];
            }
    return found;
}

double Lattice::reconstruction_max(const std::vector<float>& exact) const {
    double most = 0;
    for (const double difference : differences(exact)) most = std::max(most, std::abs(difference));
    return most;
}

std::vector<double> Lattice::worst_place(const std::vector<float>& exact) const {
    const std::vector<double> off = differences(exact);
    auto rest = static_cast<std::size_t>(
        std::max_element(off.begin(), off.end(),
                         [](double a, double b) { return std::abs(a) < std::abs(b); }) -
        off.begin());
    std::vector<double> place;
    for (std::size_t a = 0; a < lattice_.axes.size(); ++a) {
        const Line& line = lines_[a];
        place.push_back(
            axis_value_between(lattice_.axes[a], line.at[rest % line.at.size()], line.count));
        rest /= line.at.size();
    }
    return place;
}

double Lattice::rise(const std::vector<double>& off, const std::array<std::size_t, 3>& at,
                     std::size_t axis) const {
    const Line& line = lines_[axis];
    const double here = off[index(at)];
    double most = 0;
    for (const auto* neighbours : {&line.inner, &line.outer}) {
        auto before = at, after = at;
        before[axis] = (*neighbours)[at[axis]][0];
        after[axis] = (*neighbours)[at[axis]][1];
        if (before[axis] == after[axis]) continue;
        const double down = line.at[at[axis]] - line.at[before[axis]],
                     up = line.at[after[axis]] - line.at[at[axis]];
        const double low = off[index(before)], high = off[index(after)];
        if (std::abs(here) < std::max(std::abs(low), std::abs(high))) continue;
        // Where the steps are equal, the second difference.
        const double second = 2 * (up * (low - here) + down * (high - here)) / (up + down);
        most += std::abs(second) / 16;
    }
    return most;
}

double Lattice::reconstruction_bound(const std::vector<float>& exact) const {
    const std::vector<double> off = differences(exact);
    double most = 0;
    std::array<std::size_t, 3> at{};
    for (at[2] = 0; at[2] < lines_[2].at.size(); ++at[2])
        for (at[1] = 0; at[1] < lines_[1].at.size(); ++at[1])
            for (at[0] = 0; at[0] < lines_[0].at.size(); ++at[0]) {
                double value = std::abs(off[index(at)]);
                for (std::size_t axis = 0; axis < 3; ++axis) value += rise(off, at, axis);
                most = std::max(most, value);
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
