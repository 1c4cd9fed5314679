// SPDX-License-Identifier: Apache-2.0
#include "server/compute/sparse_table.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace kiln {

namespace {

/// Knots of a loose tolerance: a lobe's own features are as wide as they are far from the end.
/// Below kLoose and kLoosest more cells of that size would fail than it saves.
constexpr double kLoose = 1e-3, kLoosest = 1e-2;
KnotLine knots_for(double tolerance, const Axis& axis, std::int64_t count) {
    if (tolerance < kLoose) return KnotLine(count, axis.flip, 6, 8, axis.at);
    return KnotLine(count, axis.flip, 3, tolerance < kLoosest ? 16 : 32, axis.at);
}
/// Of the tolerance: what the interpolation may take, and what is left for the quadrature.
constexpr double kInterpolationShare = 0.25;

std::array<double, 4> lagrange(const std::array<double, 4>& knots, double x) {
    std::array<double, 4> weight{};
    for (std::size_t i = 0; i < 4; ++i) {
        weight[i] = 1;
        for (std::size_t k = 0; k < 4; ++k)
            if (k != i) weight[i] *= (x - knots[k]) / (knots[i] - knots[k]);
    }
    return weight;
}

/// The largest of each value and the eight around it.
template <typename T>
std::vector<T> most_of_neighbours(const std::vector<T>& values, std::size_t across,
                                  std::size_t down) {
    std::vector<T> most = values;
    for (std::size_t j = 0; j < down; ++j)
        for (std::size_t i = 0; i < across; ++i)
            for (std::size_t b = j == 0 ? 0 : j - 1; b <= std::min(j + 1, down - 1); ++b)
                for (std::size_t a = i == 0 ? 0 : i - 1; a <= std::min(i + 1, across - 1); ++a)
                    most[j * across + i] = std::max(most[j * across + i], values[b * across + a]);
    return most;
}

}  // namespace

KnotLine::KnotLine(std::int64_t count, bool flip, std::size_t thinning, std::size_t apart_max,
                   const std::vector<double>& positions) {
    const auto last = static_cast<std::size_t>(count) - 1;
    std::size_t at = 0;
    while (at < last) {
        knots_.push_back(at);
        at += std::clamp<std::size_t>(at / thinning, 1, apart_max);
    }
    knots_.push_back(last);
    if (flip) {
        for (std::size_t& knot : knots_) knot = last - knot;
        std::reverse(knots_.begin(), knots_.end());
    }
    const auto position = [&](std::size_t texel) {
        return positions.empty() ? static_cast<double>(texel) : positions[texel];
    };
    for (std::size_t cell = 0; cell < cells(); ++cell) {
        const std::size_t low = knots_[cell], high = knots_[cell + 1];
        std::size_t middle = low;
        double most = 0;
        for (std::size_t texel = low + 1; texel < high; ++texel) {
            const double far =
                (position(texel) - position(low)) * (position(high) - position(texel));
            if (far > most) middle = texel;
            most = std::max(most, far);
        }
        middles_.push_back(middle);
    }
    for (std::size_t texel = 0, cell = 0; texel <= last; ++texel) {
        if (cell + 1 < cells() && knots_[cell + 1] <= texel) ++cell;
        cells_.push_back(cell);
        std::array<double, 4> around{};
        for (std::size_t i = 0; i < 4; ++i) around[i] = position(knots_[first(cell) + i]);
        const std::array<double, 4> weight = lagrange(around, position(texel));
        for (std::size_t i = 0; i < 4; ++i) weights_[i].push_back(weight[i]);
    }
}

void KnotLine::interpolate(const double* knots, std::size_t begin, std::size_t end,
                           double* to) const {
    each_cell(begin, end, [&](std::size_t cell, std::size_t low, std::size_t high) {
        const double* four = knots + first(cell);
        const double a = four[0], b = four[1], c = four[2], d = four[3];
        for (std::size_t x = low; x < high; ++x)
            to[x - begin] =
                weights_[0][x] * a + weights_[1][x] * b + weights_[2][x] * c + weights_[3][x] * d;
    });
}

/// Texels that are integrated, the orders for it, and the errors of that.
struct SparseTable::Left {
    std::vector<std::size_t> places;
    std::vector<std::uint8_t> steps;
    std::vector<float> errors;
};

SparseTable::SparseTable(const JobSpec& job, const Places& places, const QuadratureKind& kind,
                         const QuadratureParameters& parameters, double tolerance, bool deficit,
                         Backend& backend)
    : places_(places),
      kind_(kind),
      parameters_(parameters),
      tolerance_(tolerance),
      backend_(backend),
      width_(static_cast<std::size_t>(job.resolution[0])),
      columns_(knots_for(tolerance, job.axes[0], job.resolution[0])),
      rows_(knots_for(tolerance, job.axes[1], job.resolution[1])),
      deficit_(deficit) {
    integrate_knots();
    judge_cells();
}

/// With no steps, orders are raised until two agree.
QuadratureResult SparseTable::integrate(const std::vector<std::size_t>& places,
                                        const std::vector<std::uint8_t>& steps) {
    if (places.empty()) return {};
    std::vector<double> NoV, alpha;
    for (const std::size_t place : places) {
        NoV.push_back(places_.NoV(place));
        alpha.push_back(places_.alpha(place));
    }
    QuadratureResult found = integrate_quadrature(backend_, kind_, {NoV, alpha, parameters_, steps},
                                                  {(1 - kInterpolationShare) * tolerance_, 0});
    evaluations_ += found.evaluations;
    return found;
}

/// Two orders may agree by chance, where the lower one's error changes its sign: a knot takes the
/// order and the error of the neighbour that has the most.
void SparseTable::integrate_knots() {
    const std::size_t across = columns_.knots().size(), down = rows_.knots().size();
    std::vector<std::size_t> list;
    for (const std::size_t y : rows_.knots())
        for (const std::size_t x : columns_.knots()) list.push_back(y * width_ + x);
    QuadratureResult found = integrate(list, {});
    unsettled_ += found.unsettled;
    knot_step_ = most_of_neighbours(found.step, across, down);
    knot_error_ = most_of_neighbours(found.error, across, down);
    std::vector<std::size_t> again, places;
    std::vector<std::uint8_t> steps;
    for (std::size_t k = 0; k < list.size(); ++k)
        if (knot_step_[k] > found.step[k]) {
            again.push_back(k);
            places.push_back(list[k]);
            steps.push_back(knot_step_[k]);
        }
    const QuadratureResult better = integrate(places, steps);
    for (std::size_t i = 0; i < again.size(); ++i) {
        found.E[again[i]] = better.E[i];
        if (deficit_) found.deficit[again[i]] = better.deficit[i];
        if (!found.B.empty()) found.B[again[i]] = better.B[i];
    }
    knots_[0] = std::move(found.E);
    if (deficit_) knots_[1] = std::move(found.deficit);
    knots_[2] = std::move(found.B);
}

/// Of the four knots around a cell.
template <typename T>
T SparseTable::most_around(const std::vector<T>& of_knots, std::size_t cell_x,
                           std::size_t cell_y) const {
    const std::size_t across = columns_.knots().size(), at = cell_y * across + cell_x;
    return std::max(std::max(of_knots[at], of_knots[at + 1]),
                    std::max(of_knots[at + across], of_knots[at + across + 1]));
}

/// The largest error of the middles of a cell and of its neighbours: at a middle alone those along
/// the two axes may cancel.
void SparseTable::judge_cells() {
    const std::size_t across = columns_.cells(), down = rows_.cells();
    std::vector<std::size_t> list;
    std::vector<std::uint8_t> steps;
    for (std::size_t j = 0; j < down; ++j)
        for (std::size_t i = 0; i < across; ++i) {
            list.push_back(rows_.middle(j) * width_ + columns_.middle(i));
            steps.push_back(most_around(knot_step_, i, j));
        }
    const QuadratureResult found = integrate(list, steps);
    std::vector<float> own(list.size());
    for (std::size_t c = 0; c < list.size(); ++c) {
        const std::size_t x = list[c] % width_, y = list[c] / width_;
        double most = std::abs(value_at(knots_[0], x, y) - found.E[c]);
        if (!found.B.empty())
            most = std::max(most, std::abs(value_at(knots_[2], x, y) - found.B[c]));
        own[c] = static_cast<float>(most);
    }
    cell_error_ = most_of_neighbours(own, across, down);
}

double SparseTable::value_at(const std::vector<double>& plane, std::size_t x, std::size_t y) const {
    const KnotLine::Between along = columns_.at(x), down = rows_.at(y);
    double sum = 0;
    for (std::size_t j = 0; j < 4; ++j) {
        const double* row = &plane[(down.first + j) * columns_.knots().size() + along.first];
        for (std::size_t i = 0; i < 4; ++i) sum += down.weight[j] * along.weight[i] * row[i];
    }
    return sum;
}

/// Texels `begin` to `end` of a row, those of cells that are integrated among them.
void SparseTable::interpolate(std::size_t row, std::size_t begin, std::size_t end, std::size_t to,
                              QuadratureResult& result) const {
    const KnotLine::Between down = rows_.at(row);
    const std::size_t knots = columns_.knots().size();
    std::vector<double> line(knots);
    std::vector<double>* const planes[] = {&result.E, &result.deficit, &result.B};
    for (std::size_t p = 0; p < kPlanes; ++p) {
        if (planes[p]->empty()) continue;
        const double* first = &knots_[p][down.first * knots];
        for (std::size_t i = 0; i < knots; ++i)
            line[i] = down.weight[0] * first[i] + down.weight[1] * first[knots + i] +
                      down.weight[2] * first[2 * knots + i] + down.weight[3] * first[3 * knots + i];
        columns_.interpolate(line.data(), begin, end, planes[p]->data() + to);
    }
}

/// Errors of texels `begin` to `end` of a row, and which of them are integrated after all.
void SparseTable::note_cells(std::size_t row, std::size_t begin, std::size_t end, std::size_t to,
                             QuadratureResult& result, Left& left) const {
    const auto bound = static_cast<float>(kInterpolationShare * tolerance_);
    const std::size_t down = rows_.at(row).cell;
    columns_.each_cell(begin, end, [&](std::size_t along, std::size_t low, std::size_t high) {
        const float of_interpolation = cell_error_[down * columns_.cells() + along];
        const float of_knots = most_around(knot_error_, along, down);
        std::fill_n(result.error.begin() + static_cast<std::ptrdiff_t>(to + low - begin),
                    high - low, of_knots + of_interpolation);
        if (of_interpolation <= bound) return;
        for (std::size_t x = low; x < high; ++x) left.places.push_back(row * width_ + x);
        left.steps.insert(left.steps.end(), high - low, most_around(knot_step_, along, down));
        left.errors.insert(left.errors.end(), high - low, of_knots);
    });
}

QuadratureResult SparseTable::take(std::size_t first, std::size_t count) {
    QuadratureResult result;
    result.E.resize(count);
    if (deficit_) result.deficit.resize(count);
    if (!knots_[2].empty()) result.B.resize(count);
    result.error.resize(count);
    Left left;
    for (std::size_t at = first; at < first + count;) {
        const std::size_t row = at / width_, begin = at % width_;
        const std::size_t end = std::min(width_, begin + (first + count - at));
        interpolate(row, begin, end, at - first, result);
        note_cells(row, begin, end, at - first, result, left);
        at += end - begin;
    }
    interpolated_ += count - left.places.size();
    const QuadratureResult found = integrate(left.places, left.steps);
    for (std::size_t i = 0; i < left.places.size(); ++i) {
        const std::size_t to = left.places[i] - first;
        result.E[to] = found.E[i];
        if (deficit_) result.deficit[to] = found.deficit[i];
        if (!found.B.empty()) result.B[to] = found.B[i];
        result.error[to] = left.errors[i];
    }
    result.evaluations = std::exchange(evaluations_, 0);
    result.unsettled = std::exchange(unsettled_, 0);
    return result;
}

}  // namespace kiln
