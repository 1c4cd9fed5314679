// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstddef>
#include <numbers>
#include <vector>

#include "server/compute/fresnel.h"

namespace kiln {
namespace {

constexpr int kNodes = 16;

struct GaussLegendre {
    std::array<double, kNodes> x, weight;  // on [0, 1]
};

// Nodes by Newton's method on the three-term recurrence of the Legendre polynomials.
GaussLegendre gauss_legendre() {
    GaussLegendre rule{};
    for (int i = 0; i < kNodes; ++i) {
        double x = std::cos(std::numbers::pi * (i + 0.75) / (kNodes + 0.5)), slope = 1;
        for (int step = 0; step < 8; ++step) {
            double before = 1, p = x;
            for (int n = 2; n <= kNodes; ++n) {
                const double next = ((2 * n - 1) * x * p - (n - 1) * before) / n;
                before = p;
                p = next;
            }
            slope = kNodes * (x * p - before) / ((x - 1) * (x + 1));
            x -= p / slope;
        }
        rule.x[static_cast<std::size_t>(i)] = (1 + x) / 2;
        rule.weight[static_cast<std::size_t>(i)] = 1 / ((1 - x) * (1 + x) * slope * slope);
    }
    return rule;
}

/// 2 ∫ F(μ) μ dμ by Gauss-Legendre panels, halved until two halves agree with the whole to 1e-13 of
/// it, or to 1e-16: what rounding leaves at the rim of total reflection.
class Average {
  public:
    Average(const FresnelModel& model, int channel) : model_(model), channel_(channel) {}

    /// Panels begin at `splits`; those outside of (0, 1) are left out.
    double operator()(std::vector<double> splits) const {
        std::erase_if(splits, [](double at) { return !(at > 0 && at < 1); });
        splits.push_back(0);
        splits.push_back(1);
        std::sort(splits.begin(), splits.end());
        double sum = 0;
        for (std::size_t i = 0; i + 1 < splits.size(); ++i)
            sum += halved(splits[i], splits[i + 1], panel(splits[i], splits[i + 1]), 0);
        return sum;
    }

  private:
    double panel(double a, double b) const {
        double sum = 0;
        for (std::size_t i = 0; i < kNodes; ++i) {
            const double mu = a + (b - a) * rule_.x[i];
            sum += rule_.weight[i] * 2 * mu * fresnel(model_, channel_, mu);
        }
        return sum * (b - a);
    }

    double halved(double a, double b, double whole, int depth) const {
        const double middle = a + (b - a) / 2;
        const double left = panel(a, middle), right = panel(middle, b);
        // A root at a panel's end loses a factor of 2.8 a halving: 40 leave 1e-18 of the panel.
        if (std::abs(left + right - whole) <= 1e-13 * whole + 1e-16 || depth == 40)
            return left + right;
        return halved(a, middle, left, depth + 1) + halved(middle, b, right, depth + 1);
    }

    const FresnelModel& model_;
    int channel_;
    GaussLegendre rule_ = gauss_legendre();
};

// Walsh 1926; n > 1. Its terms grow as 1 / (n − 1) and cancel.
double dielectric_average_above(double n) {
    const double n2 = n * n, plus = n2 + 1, minus = (n - 1) * (n + 1);
    const double n4_minus_1 = plus * minus;
    return 0.5 + (n - 1) * (3 * n + 1) / (6 * (n + 1) * (n + 1)) +
           n2 * minus * minus / (plus * plus * plus) * std::log1p(-2 / (n + 1)) -
           2 * n * n2 * (n2 + 2 * n - 1) / (plus * n4_minus_1) +
           8 * n2 * n2 * (n2 * n2 + 1) / (plus * n4_minus_1 * n4_minus_1) * std::log(n);
}

double dielectric_average(double n) {
    if (n == 1) return 0;
    // What passes a boundary passes it both ways: n² (1 − F_avg(1/n)) = 1 − F_avg(n).
    if (n < 1) return 1 - n * n * (1 - dielectric_average(1 / n));
    // Here the terms of the closed form cancel to 1e-14; nearer to 1 to less.
    if (n >= 1.01) return dielectric_average_above(n);
    FresnelModel model{.model = Fresnel::dielectric};
    model.ior = {n};
    std::vector<double> splits;  // F falls from 1 to ((n − 1)/2)² within some √(n² − 1) of 0
    for (double at = std::sqrt((n - 1) * (n + 1)) / 4; at < 1; at *= 2) splits.push_back(at);
    return Average(model, 0)(splits);
}

double conductor_average(const FresnelModel& model, int channel) {
    const auto p = fresnel_parameters(model, channel);
    if (p[2] == 0 && p[1] > 0) return dielectric_average(std::sqrt(p[1]));
    // √(ε − 1 + μ²) has a branch point, near the real axis where k is small and eta < 1: the rim of
    // total reflection.
    const std::complex<double> contrast(p[0], p[2]);
    std::vector<double> splits = {std::sqrt(-contrast).real()};
    // A pseudo-Brewster dip at grazing, where |ε| is large.
    splits.push_back(1 / std::sqrt(1 + p[3]));
    return Average(model, channel)(splits);
}

}  // namespace

double fresnel_average(const FresnelModel& model, int channel) {
    const auto p = fresnel_parameters(model, channel);
    switch (model.model) {
        case Fresnel::none:
            return 1;
        case Fresnel::schlick:  // ∫ (1 − μ)^n μ dμ = 1 / ((n + 1) (n + 2))
            return p[0] + p[1] * 2 / ((p[2] + 1) * (p[2] + 2));
        case Fresnel::dielectric:
            return dielectric_average(
                model.ior[model.ior.size() == 1 ? 0 : static_cast<std::size_t>(channel)]);
        case Fresnel::conductor:
        case Fresnel::edge_tint:
            return conductor_average(model, channel);
        case Fresnel::f82_tint:  // ∫ μ² (1 − μ)^6 dμ = 1 / 252
            return p[0] + p[1] / 21 + p[2] / 126;
    }
    __builtin_unreachable();
}

}  // namespace kiln
