// SPDX-License-Identifier: Apache-2.0
#include "server/measured/hemisphere.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace kiln::measured {

Hemisphere::Hemisphere(const Incidence& incidence, std::size_t channels)
    : theta_i_(incidence.theta_i), phi_i_(incidence.phi_i), channels_(channels) {
    std::vector<Triangulation::Point> points;
    std::vector<std::size_t> source;
    for (std::size_t n = 0; n < incidence.out.size(); ++n)
        if (usable(incidence.state[n])) {
            points.push_back({incidence.out[n].x, incidence.out[n].y});
            source.push_back(n);
        }
    mesh_ = std::make_unique<Triangulation>(points);
    inner_ = mesh_->inner();
    // Readings of one direction are averaged.
    std::vector<double> sums(mesh_->node_count() * channels);
    std::vector<double> counts(mesh_->node_count());
    for (std::size_t p = 0; p < points.size(); ++p) {
        const std::size_t node = mesh_->node_of()[p] - 3;
        counts[node] += 1;
        for (std::size_t c = 0; c < channels; ++c)
            sums[node * channels + c] += incidence.values[source[p] * channels + c];
    }
    for (std::size_t k = 0; k < sums.size(); ++k)
        node_values_.push_back(static_cast<float>(sums[k] / counts[k / channels]));
    if (!incidence.patch.empty()) {
        patch_albedo_.assign(channels, 0.0);
        for (const std::size_t n : source) {
            patch_coverage_ += incidence.patch[n] / std::numbers::pi;
            for (std::size_t c = 0; c < channels; ++c)
                patch_albedo_[c] +=
                    static_cast<double>(incidence.patch[n]) * incidence.values[n * channels + c];
        }
    }
    find_holes(incidence);
}

/// A triangle that holds a direction which the file leaves out spans a hole.
void Hemisphere::find_holes(const Incidence& incidence) {
    std::uint32_t last = 0;
    for (const std::uint32_t t : inner_) last = std::max(last, t);
    triangle_origin_.assign(inner_.empty() ? 0 : last + 1, Origin::kMeasured);
    std::uint32_t hint = Triangulation::kNone;
    for (std::size_t n = 0; n < incidence.out.size(); ++n) {
        if (usable(incidence.state[n])) continue;
        const auto place = mesh_->locate({incidence.out[n].x, incidence.out[n].y}, hint);
        const bool inside = place.triangle != Triangulation::kNone &&
                            *std::max_element(place.weight.begin(), place.weight.end()) < 0.999;
        if (inside) triangle_origin_[place.triangle] = Origin::kInterpolated;
    }
}

bool Hemisphere::value(Vec out, std::uint32_t& hint, double* values, Origin& origin) const {
    const auto place = mesh_->locate({out.x, out.y}, hint);
    if (place.triangle == Triangulation::kNone || out.z < 0) return false;
    origin = triangle_origin_[place.triangle];
    const auto& nodes = mesh_->triangle(place.triangle).node;
    for (std::size_t c = 0; c < channels_; ++c) {
        values[c] = 0;
        for (std::size_t k = 0; k < 3; ++k)
            values[c] += place.weight[k] * node_values_[(nodes[k] - 3) * channels_ + c];
    }
    return true;
}

std::vector<double> Hemisphere::albedo() const {
    if (!patch_albedo_.empty()) return patch_albedo_;
    std::vector<double> sum(channels_);
    for (const std::uint32_t t : inner_)
        for (const std::uint32_t node : mesh_->triangle(t).node)
            for (std::size_t c = 0; c < channels_; ++c)
                sum[c] += mesh_->area(t) / 3 * node_values_[(node - 3) * channels_ + c];
    return sum;
}

double Hemisphere::coverage() const {
    if (!patch_albedo_.empty()) return patch_coverage_;
    double area = 0;
    for (const std::uint32_t t : inner_) area += mesh_->area(t);
    return area / std::numbers::pi;
}

Hemisphere::Spacing Hemisphere::spacing() const {
    std::vector<double> roots, turns;
    for (const std::uint32_t t : inner_) {
        std::array<double, 3> root{}, turn{};
        for (std::size_t k = 0; k < 3; ++k) {
            const auto p = mesh_->position(mesh_->triangle(t).node[k]);
            const double z = std::sqrt(std::max(0.0, 1 - p.x * p.x - p.y * p.y));
            const Vec d = to_mirror(theta_i_, {p.x, p.y, z});
            root[k] = std::sqrt(std::sin(theta_of(d) * kDegree / 2));
            // Relative to the first corner, so that no seam runs through the triangle.
            turn[k] = k == 0 ? phi_of(d) : std::remainder(phi_of(d) - turn[0], 360.0);
        }
        turn[0] = 0;
        const auto width = [](const std::array<double, 3>& list) {
            const auto [low, high] = std::minmax_element(list.begin(), list.end());
            return *high - *low;
        };
        roots.push_back(width(root));
        turns.push_back(width(turn) / 360);
    }
    const auto quartile = [](std::vector<double>& list) {
        const auto at = list.begin() + static_cast<std::ptrdiff_t>(list.size() / 4);
        std::nth_element(list.begin(), at, list.end());
        return *at;
    };
    if (roots.empty()) return {};
    return {quartile(roots), quartile(turns)};
}

namespace {

/// f(i, o) and f(o, i) of one pair of directions.
class ReciprocityPairs {
  public:
    /// Views stand in the frame of each hemisphere's light.
    void add(const Hemisphere& first, Vec out, const Hemisphere& second, Vec back_out) {
        std::vector<double> there(first.channels()), back(first.channels());
        Origin one{}, other{};
        std::uint32_t hint = Triangulation::kNone;
        if (!first.value(out, hint, there.data(), one)) return;
        hint = Triangulation::kNone;
        if (!second.value(back_out, hint, back.data(), other)) return;
        if (one != Origin::kMeasured || other != Origin::kMeasured) return;
        double x = 0, y = 0;
        for (std::size_t c = 0; c < there.size(); ++c) {
            x += there[c];
            y += back[c];
        }
        const double mean = 0.5 * (std::abs(x) + std::abs(y));
        if (mean > 0) differences_.push_back(std::abs(x - y) / mean);
    }
    bool full() const { return differences_.size() > 100000; }
    ReciprocityError error() {
        ReciprocityError error{differences_.size(), 0, 0};
        if (differences_.empty()) return error;
        std::sort(differences_.begin(), differences_.end());
        error.median = differences_[differences_.size() / 2];
        error.p95 = differences_[std::min(differences_.size() - 1, differences_.size() * 95 / 100)];
        return error;
    }

  private:
    std::vector<double> differences_;
};

}  // namespace

ReciprocityError reciprocity_error(const std::vector<Hemisphere>& incidences) {
    bool turns = false;  // two azimuths under one theta_in: then each stands where it is
    for (std::size_t n = 1; n < incidences.size(); ++n)
        turns = turns || incidences[n].theta_i() == incidences[n - 1].theta_i();
    ReciprocityPairs pairs;
    for (std::size_t a = 0; a < incidences.size(); ++a)
        for (std::size_t b = a + 1; b < incidences.size() && !pairs.full(); ++b) {
            const Hemisphere &first = incidences[a], &second = incidences[b];
            const double turn = second.phi_i() - first.phi_i();
            if (turns)
                pairs.add(first, direction(second.theta_i(), turn), second,
                          direction(first.theta_i(), -turn));
            else if (first.theta_i() != second.theta_i())
                for (int at = 0; at < 360; at += 10)
                    // Light and view change places, then both are turned back by the azimuth.
                    pairs.add(first, direction(second.theta_i(), at), second,
                              direction(first.theta_i(), -at));
        }
    return pairs.error();
}

}  // namespace kiln::measured
