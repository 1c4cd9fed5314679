// SPDX-License-Identifier: Apache-2.0
#include "server/compute/facet_space.h"

#include <algorithm>
#include <cmath>

#include "server/compute/one_lane.h"
#include "server/compute/quadrature.h"

namespace kiln {

namespace {

/// Rings in a piece of their variable, which ends where a direction stops seeing the whole ring.
constexpr unsigned kRingsAPiece = 8;
/// 90 are enough at albedo 1 and alpha 1.
constexpr int kRoundsMax = 200;
/// Below this alpha, facets are Lambert's plane to less than rounding leaves of their rings.
constexpr double kSmooth = 1e-10;

/// ∫ <d, m> over the azimuth of normals m, for a direction of this cosine (−1 … 1) and sine.
double seen_of_ring(double cosine, double sine, double ring_cosine, double ring_sine) {
    const double along = cosine * ring_cosine, across = sine * ring_sine;
    if (along >= across) return 2 * 3.14159265358979324 * along;
    if (along <= -across) return 0;
    const double x = -along / across;
    return 2 * (one_lane::lane_acos(x) * along + across * std::sqrt((1 - x) * (1 + x)));
}

}  // namespace

FacetSpace::FacetSpace(double alpha, unsigned directions) : alpha_(alpha) {
    if (alpha < kSmooth) return;
    // Cosine and sine are rational in t = tan of half the elevation, which is dense at grazing.
    const std::vector<double> rule = gauss_legendre({directions});
    for (unsigned i = 0; i < directions; ++i) {
        const double u = rule[2 * i], t = u * u, scale = 1 / (1 + t * t);
        const double sine = (1 - t) * (1 + t) * scale;
        rule_.push_back({2 * t * scale, sine, rule[2 * i + 1] * 2 * u * 2 * sine * scale});
    }
    edges_ = {0};
    for (const Direction& d : rule_) {
        rate_.push_back(lambda(d));
        edges_.push_back(edge_of(d));
    }
    edges_.push_back(1);
    for (std::size_t i = 0; i + 1 < edges_.size(); ++i)
        append_rings(edges_[i], edges_[i + 1], rings_);
    seen_ = seen_by_rule(rings_);
    for (const Direction& d : rule_)
        for (const bool above : {true, false}) {
            Turned to(2 * rule_.size());
            turn(d, above, rings_, seen_, to);
            normalise(to);
            (above ? from_above_ : from_below_).push_back(std::move(to));
        }
}

/// Heitz 2014, eq. 72.
double FacetSpace::lambda(const Direction& d) const {
    const double slope = alpha_ * d.sine / d.cosine, square = slope * slope;
    return 0.5 * square / (1 + std::sqrt(1 + square));
}

/// Where a ring of normals begins to turn away from the direction, in the rings' variable.
double FacetSpace::edge_of(const Direction& d) const {
    const double along = d.cosine, across = d.sine * alpha_;
    return along / (across + std::sqrt(along * along + across * across));
}

/// D dm = sin ψ √(cos²ψ + α² sin²ψ) dψ dφ / π with tan θm = α tan ψ; the variable is tan(ψ / 2).
/// Towards `begin`, where some direction has a fold of exponent 3/2, it is quadratic in the node.
void FacetSpace::append_rings(double begin, double end, std::vector<Ring>& rings) const {
    static const std::vector<double> rule = gauss_legendre({kRingsAPiece});
    for (unsigned i = 0; i < kRingsAPiece; ++i) {
        const double u = rule[2 * i], q = begin + (end - begin) * u * u;
        const double scale = 1 / (1 + q * q), c = (1 - q) * (1 + q) * scale, s = 2 * q * scale;
        const double stretch = std::sqrt(c * c + alpha_ * alpha_ * s * s);
        const double step = rule[2 * i + 1] * (end - begin) * 2 * u * 2 * scale;
        rings.push_back({c / stretch, alpha_ * s / stretch, s * stretch * step});
    }
}

std::vector<double> FacetSpace::seen_by_rule(std::span<const Ring> rings) const {
    std::vector<double> seen;
    for (const Ring& ring : rings)
        for (const double facing : {1., -1.})
            for (const Direction& d : rule_)
                seen.push_back(seen_of_ring(facing * d.cosine, d.sine, ring.cosine, ring.sine));
    return seen;
}

void FacetSpace::turn(const Direction& from, bool above, std::span<const Ring> rings,
                      std::span<const double> seen, Turned& to) const {
    const double facing = above ? from.cosine : -from.cosine;
    for (std::size_t r = 0; r < rings.size(); ++r) {
        const Ring& ring = rings[r];
        const double met = ring.weight * seen_of_ring(facing, from.sine, ring.cosine, ring.sine);
        for (std::size_t i = 0; i < to.size(); ++i) to[i] += met * seen[to.size() * r + i];
    }
}

void FacetSpace::normalise(Turned& to) const {
    double sum = 0;
    for (std::size_t i = 0; i < to.size(); ++i) sum += to[i] *= rule_[i % rule_.size()].weight;
    for (double& share : to) share /= sum;
}

FacetSpace::Turned FacetSpace::first_turn(const Direction& view) const {
    const double edge = edge_of(view);
    const auto next = std::upper_bound(edges_.begin() + 1, edges_.end() - 1, edge);
    const auto piece = static_cast<std::size_t>(next - edges_.begin()) - 1;
    // That piece in two, the others as they are.
    const std::size_t before = piece * kRingsAPiece, after = before + kRingsAPiece;
    const std::size_t width = 2 * rule_.size();
    const std::span<const Ring> rings = rings_;
    const std::span<const double> seen = seen_;
    std::vector<Ring> own;
    append_rings(edges_[piece], edge, own);
    append_rings(edge, edges_[piece + 1], own);
    Turned to(width);
    turn(view, true, rings.first(before), seen.first(before * width), to);
    turn(view, true, rings.subspan(after), seen.subspan(after * width), to);
    turn(view, true, own, seen_by_rule(own), to);
    normalise(to);
    return to;
}

FacetSpace::Lit FacetSpace::lit(double rho) const {
    const std::size_t n = rule_.size();
    Lit light{rho, std::vector<double>(n * n), std::vector<double>(n * n)};
    std::vector<double>& R = light.reflected;
    std::vector<double> next(n * n), row(n);
    // Each round adds what takes one facet more; a third of the light and more leaves each.
    for (int round = 0; round < kRoundsMax; ++round) {
        // Where light that a ray meets on its way up goes on, with what comes back from below.
        for (std::size_t i = 0; i < n; ++i) {
            double* to = &light.rising[i * n];
            std::copy_n(from_below_[i].begin(), n, to);
            for (std::size_t k = 0; k < n; ++k) {
                const double down = from_below_[i][n + k];
                for (std::size_t j = 0; j < n; ++j) to[j] += down * R[k * n + j];
            }
            for (std::size_t j = 0; j < n; ++j) to[j] *= rho * rate_[i];
        }
        double change = 0;
        for (std::size_t i = 0; i < n; ++i) {
            const double rate = 1 + rate_[i];
            std::copy_n(from_above_[i].begin(), n, row.begin());
            for (std::size_t k = 0; k < n; ++k) {
                const double down = from_above_[i][n + k];
                for (std::size_t j = 0; j < n; ++j) row[j] += down * R[k * n + j];
            }
            for (std::size_t j = 0; j < n; ++j) row[j] *= rho * rate;
            for (std::size_t k = 0; k < n; ++k) {
                const double up = R[i * n + k];
                for (std::size_t j = 0; j < n; ++j) row[j] += up * light.rising[k * n + j];
            }
            for (std::size_t j = 0; j < n; ++j) {
                next[i * n + j] = row[j] / (rate + rate_[j]);
                change = std::max(change, std::abs(next[i * n + j] - R[i * n + j]));
            }
        }
        R.swap(next);
        if (change < 1e-14) break;
    }
    return light;
}

/// What gets out of light that goes up from facets which a ray from `view` meets, at the rate r:
/// (r + Λ) out = r + rising out, divided by r, which has no end at grazing.
std::vector<double> FacetSpace::let_out(const Direction& view, const Lit& light) const {
    const std::size_t n = rule_.size();
    const double stretched = alpha_ * view.sine;
    const double spread = std::sqrt(view.cosine * view.cosine + stretched * stretched);
    const double length = 2 * view.cosine / (view.cosine + spread);
    std::vector<double> m(n * n), out(n, 1.0);
    for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t j = 0; j < n; ++j) m[i * n + j] = -length * light.rising[i * n + j];
        m[i * n + i] += 1 + length * rate_[i];
    }
    // Gauss: the diagonal outweighs its row.
    for (std::size_t k = 0; k < n; ++k)
        for (std::size_t i = k + 1; i < n; ++i) {
            const double factor = m[i * n + k] / m[k * n + k];
            for (std::size_t j = k + 1; j < n; ++j) m[i * n + j] -= factor * m[k * n + j];
            out[i] -= factor * out[k];
        }
    for (std::size_t k = n; k-- > 0;) {
        for (std::size_t j = k + 1; j < n; ++j) out[k] -= m[k * n + j] * out[j];
        out[k] /= m[k * n + k];
    }
    return out;
}

std::vector<double> FacetSpace::albedo(double NoV, std::span<const Lit> lights) const {
    const std::size_t n = rule_.size();
    std::vector<double> values;
    if (alpha_ < kSmooth) {
        for (const Lit& light : lights) values.push_back(light.rho);
        return values;
    }
    const Direction view{NoV, std::sqrt((1 - NoV) * (1 + NoV)), 0};
    const Turned first = first_turn(view);
    for (const Lit& light : lights) {
        const std::vector<double> out = let_out(view, light);
        double sum = 0;
        for (std::size_t i = 0; i < n; ++i) {
            sum += first[i] * out[i];
            for (std::size_t j = 0; j < n; ++j)
                sum += first[n + i] * light.reflected[i * n + j] * out[j];
        }
        values.push_back(light.rho * sum);
    }
    return values;
}

double FacetSpace::average(const Lit& light) const {
    if (alpha_ < kSmooth) return light.rho;
    const std::size_t n = rule_.size();
    double sum = 0;
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = 0; j < n; ++j)
            sum += 2 * rule_[i].weight * rule_[i].cosine * light.reflected[i * n + j];
    return sum;
}

}  // namespace kiln
