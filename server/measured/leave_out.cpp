// SPDX-License-Identifier: Apache-2.0
// A hemisphere's own test: parts of its points predicted from the others.
#include <algorithm>
#include <cmath>

#include "server/measured/hemisphere.h"

namespace kiln::measured {
namespace {

/// SplitMix64's finaliser (Steele, Lea and Flood 2014): an order of the nodes.
std::uint64_t scrambled(std::uint64_t z) {
    z = (z + 1) * 0x9e3779b97f4a7c15;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9;
    z = (z ^ z >> 27) * 0x94d049bb133111eb;
    return z ^ z >> 31;
}

double distance(Triangulation::Point a, Triangulation::Point b) {
    return std::hypot(a.x - b.x, a.y - b.y);
}

/// Cells of a grid over the square: neighbours of a place without looking at all nodes.
class Grid {
  public:
    explicit Grid(const std::vector<Triangulation::Point>& places) : places_(places) {
        side_ = std::clamp<std::size_t>(
            static_cast<std::size_t>(std::sqrt(static_cast<double>(places.size()) / 4)), 1, 512);
        cells_.resize(side_ * side_);
        for (std::size_t n = 0; n < places.size(); ++n)
            cells_[cell(places[n].y) * side_ + cell(places[n].x)].push_back(n);
    }
    template <typename Body>
    void within(Triangulation::Point at, double radius, Body body) const {
        for (std::size_t y = cell(at.y - radius); y <= cell(at.y + radius); ++y)
            for (std::size_t x = cell(at.x - radius); x <= cell(at.x + radius); ++x)
                for (const std::size_t n : cells_[y * side_ + x])
                    if (distance(places_[n], at) <= radius) body(n);
    }

  private:
    std::size_t cell(double v) const {
        const auto side = static_cast<double>(side_);
        return static_cast<std::size_t>(std::clamp((v + 1) / 2 * side, 0.0, side - 1));
    }
    const std::vector<Triangulation::Point>& places_;
    std::size_t side_;
    std::vector<std::vector<std::size_t>> cells_;
};

struct Nodes {
    std::vector<Triangulation::Point> place;
    std::vector<double> reach;  ///< the longest edge
    std::vector<bool> rim;      ///< on the hull, or at a hole
};

/// Nodes to predict, far enough from each other that what is left out for one is not missed by
/// another.
std::vector<std::size_t> chosen(const Nodes& nodes, const Grid& grid, std::uint64_t round) {
    std::vector<std::size_t> order(nodes.place.size());
    for (std::size_t n = 0; n < order.size(); ++n) order[n] = n;
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
        return scrambled(4 * a + round) < scrambled(4 * b + round);
    });
    std::vector<bool> taken(order.size());
    std::vector<std::size_t> list;
    for (const std::size_t n : order) {
        if (taken[n] || nodes.rim[n]) continue;
        list.push_back(n);
        grid.within(nodes.place[n], 4 * nodes.reach[n], [&](std::size_t m) { taken[m] = true; });
    }
    return list;
}

}  // namespace

Hemisphere::Prediction Hemisphere::leave_regions_out(std::uint64_t round) const {
    Nodes nodes;
    const std::size_t count = node_count();
    nodes.reach.resize(count);
    nodes.rim.resize(count);
    for (std::size_t n = 0; n < count; ++n)
        nodes.place.push_back(mesh_->position(static_cast<std::uint32_t>(n + 3)));
    std::vector<bool> inner(inner_.empty() ? 0 : triangle_origin_.size());
    for (const std::uint32_t t : inner_) inner[t] = true;
    for (const std::uint32_t t : inner_) {
        const auto& triangle = mesh_->triangle(t);
        for (std::size_t k = 0; k < 3; ++k) {
            const std::size_t n = triangle.node[k] - 3, m = triangle.node[(k + 1) % 3] - 3;
            const std::uint32_t across = triangle.across[(k + 2) % 3];
            const double length = distance(nodes.place[n], nodes.place[m]);
            const bool open = across >= inner.size() || !inner[across] ||
                              triangle_origin_[t] != Origin::kMeasured;
            for (const std::size_t end : {n, m}) {
                nodes.reach[end] = std::max(nodes.reach[end], length);
                if (open) nodes.rim[end] = true;
            }
        }
    }
    const Grid grid(nodes.place);
    const std::vector<std::size_t> tested = chosen(nodes, grid, round);
    std::vector<bool> left(count);
    for (const std::size_t n : tested)
        grid.within(nodes.place[n], 0.75 * nodes.reach[n], [&](std::size_t m) { left[m] = true; });
    std::vector<Triangulation::Point> kept;
    std::vector<std::size_t> source;
    for (std::size_t n = 0; n < count; ++n)
        if (!left[n]) {
            kept.push_back(nodes.place[n]);
            source.push_back(n);
        }
    const Triangulation rest(kept);
    std::vector<std::size_t> node_source(rest.node_count());
    for (std::size_t p = 0; p < kept.size(); ++p) node_source[rest.node_of()[p] - 3] = source[p];
    Prediction result;
    std::uint32_t hint = Triangulation::kNone;
    for (const std::size_t n : tested) {
        const auto at = rest.locate(nodes.place[n], hint);
        if (at.triangle == Triangulation::kNone) continue;
        double predicted = 0, value = 0;
        for (std::size_t c = 0; c < channels_; ++c) {
            value += node_values_[n * channels_ + c];
            for (std::size_t k = 0; k < 3; ++k) {
                const std::size_t from = node_source[rest.triangle(at.triangle).node[k] - 3];
                predicted += at.weight[k] * node_values_[from * channels_ + c];
            }
        }
        // A tested node stands for its neighbourhood: the denser the nodes, the more are tested.
        const double weight = nodes.reach[n] * nodes.reach[n];
        result.off += weight * std::abs(predicted - value);
        result.all += weight * std::abs(value);
    }
    return result;
}

}  // namespace kiln::measured
