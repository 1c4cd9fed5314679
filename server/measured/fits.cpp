// SPDX-License-Identifier: Apache-2.0
#include "server/measured/fits.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace kiln::measured {
namespace {

constexpr double kPi = std::numbers::pi;

/// Cosines that the models need.
struct Geometry {
    double NoL = 0, NoV = 0, NoH = 0, VoH = 0, VoR = 0;
};
Geometry geometry(double theta_in, Vec out) {
    const Vec in = direction(theta_in, 0), mirror = direction(theta_in, 180);
    const Vec half = in + out;
    const double length = std::sqrt(dot(half, half));
    Geometry g{in.z, out.z, 1, 1, dot(out, mirror)};
    if (length > 1e-12) g.NoH = half.z / length, g.VoH = length / 2;
    return g;
}

/// The functions whose multiples make f: of the diffuse colour, of f0, of f90.
using Basis = std::array<double, 3>;
Basis basis(FitModel model, double width, const Geometry& g) {
    if (model == FitModel::lafortune_phong)
        return {1 / kPi, (width + 2) / (2 * kPi) * std::pow(std::max(0.0, g.VoR), width), 0};
    const double a2 = width * width, bowl = g.NoH * g.NoH * (a2 - 1) + 1;
    const double d = a2 / (kPi * bowl * bowl);
    const double masks = g.NoL * std::sqrt(a2 + (1 - a2) * g.NoV * g.NoV) +
                         g.NoV * std::sqrt(a2 + (1 - a2) * g.NoL * g.NoL);
    const double schlick = std::pow(1 - g.VoH, 5.0), lobe = masks > 0 ? 0.5 * d / masks : 0.0;
    return {1 / kPi, lobe * (1 - schlick), lobe * schlick};
}

/// A measured direction; `solid` is its projected solid angle, `weight` that of its square.
struct Sample {
    Geometry geometry;
    Colour f{};
    std::array<double, 3> weight{};
    double solid = 0;
    std::size_t lobe = 0;
};

/// Midpoints about the mirror direction, dense at the peak and ending at the horizon.
void add_samples(double theta_in, std::size_t lobe, const LobeTables& tables, Resampler& resampler,
                 std::vector<Sample>& samples) {
    constexpr int kRings = 36, kSpokes = 48;
    const double c = std::cos(theta_in * kDegree), s = std::sin(theta_in * kDegree);
    std::vector<Vec> out;
    std::vector<double> solid;
    for (int ring = 0; ring < kRings; ++ring)
        for (int spoke = 0; spoke < kSpokes; ++spoke) {
            const double turn = 360.0 * (spoke + 0.5) / kSpokes;
            const double end =
                std::sqrt(std::sin(0.5 * std::atan2(c, s * std::cos(turn * kDegree))));
            const double u = end * (ring + 0.5) / kRings;
            const Vec d = direction(2 * std::asin(u * u) / kDegree, turn);
            const Vec view = from_mirror(theta_in, d);
            if (view.z < 1e-3) continue;
            out.push_back(view);
            solid.push_back(8 * u * u * u * end / kRings * 2 * kPi / kSpokes * view.z);
        }
    const Sampled found = resampler.values(tables, theta_in, out);
    Colour mean{};
    double all = 0;
    const std::size_t first = samples.size();
    for (std::size_t n = 0; n < out.size(); ++n) {
        if (found.origin[n] > 1.5f) continue;
        const Colour f = {found.r[n], found.g[n], found.b[n]};
        samples.push_back({geometry(theta_in, out[n]), f, {}, solid[n], lobe});
        all += solid[n];
        for (std::size_t k = 0; k < 3; ++k) mean[k] += solid[n] * std::abs(f[k]);
    }
    for (std::size_t n = first; n < samples.size(); ++n)
        for (std::size_t k = 0; k < 3; ++k) {
            const double scale = std::abs(samples[n].f[k]) + 0.1 * mean[k] / all;
            samples[n].weight[k] = scale > 0 ? samples[n].solid / scale : 0;
        }
}

/// Normal equations of one channel.
struct Equations {
    double matrix[3][3] = {}, right[3] = {}, square = 0;
    void add(const Basis& b, double f, double weight) {
        for (std::size_t i = 0; i < 3; ++i) {
            for (std::size_t k = 0; k < 3; ++k) matrix[i][k] += weight * b[i] * b[k];
            right[i] += weight * b[i] * f;
        }
        square += weight * f * f;
    }
    double residual(const Basis& x) const {
        double sum = square;
        for (std::size_t i = 0; i < 3; ++i) {
            sum -= 2 * x[i] * right[i];
            for (std::size_t k = 0; k < 3; ++k) sum += x[i] * matrix[i][k] * x[k];
        }
        return std::max(0.0, sum);
    }
    /// Of the two first unknowns, with the third given; neither negative.
    Basis solve_two(double third) const {
        double r[2];
        for (std::size_t i = 0; i < 2; ++i) r[i] = right[i] - matrix[i][2] * third;
        const double det = matrix[0][0] * matrix[1][1] - matrix[0][1] * matrix[1][0];
        Basis best = {0, 0, third};
        const auto attempt = [&](double a, double b) {
            const Basis x = {a, b, third};
            if (a >= 0 && b >= 0 && residual(x) < residual(best)) best = x;
        };
        if (matrix[0][0] > 0) attempt(r[0] / matrix[0][0], 0);
        if (matrix[1][1] > 0) attempt(0, r[1] / matrix[1][1]);
        if (std::abs(det) > 1e-12 * matrix[0][0] * matrix[1][1])
            attempt((r[0] * matrix[1][1] - r[1] * matrix[0][1]) / det,
                    (r[1] * matrix[0][0] - r[0] * matrix[1][0]) / det);
        return best;
    }
};

struct Linear {
    std::array<Basis, 3> x{};  ///< a channel each
    double f90 = 1, residual = 0;
};

/// The best multiples at one width; f90 is one for all channels.
Linear solve(FitModel model, double width, const std::vector<Sample>& samples, bool free_f90) {
    std::array<Equations, 3> channel;
    for (const Sample& one : samples) {
        const Basis b = basis(model, width, one.geometry);
        for (std::size_t k = 0; k < 3; ++k) channel[k].add(b, one.f[k], one.weight[k]);
    }
    const auto at = [&](double f90) {
        Linear made{{}, f90, 0};
        for (std::size_t k = 0; k < 3; ++k) {
            made.x[k] = channel[k].solve_two(f90);
            made.residual += channel[k].residual(made.x[k]);
        }
        return made;
    };
    if (model == FitModel::lafortune_phong) return at(0);
    if (!free_f90) return at(1);
    // Convex in f90.
    double low = 0, high = 4;
    for (int n = 0; n < 40; ++n) {
        const double a = low + 0.382 * (high - low), b = low + 0.618 * (high - low);
        (at(a).residual < at(b).residual ? high : low) = at(a).residual < at(b).residual ? b : a;
    }
    return at(0.5 * (low + high));
}

/// Scan and golden sections over the logarithm of the width.
std::pair<double, Linear> best_width(FitModel model, const std::vector<Sample>& samples,
                                     bool free_f90) {
    const double low = model == FitModel::ggx_diffuse ? 0.01 : 0.5;
    const double high = model == FitModel::ggx_diffuse ? 1.0 : 2e4;
    constexpr int kSteps = 40;
    const auto width = [&](double t) { return low * std::pow(high / low, t); };
    int best = 0;
    double least = INFINITY;
    for (int n = 0; n <= kSteps; ++n) {
        const double residual =
            solve(model, width(static_cast<double>(n) / kSteps), samples, free_f90).residual;
        if (residual < least) least = residual, best = n;
    }
    double a = std::max(0, best - 1) / static_cast<double>(kSteps);
    double b = std::min(kSteps, best + 1) / static_cast<double>(kSteps);
    for (int n = 0; n < 28; ++n) {
        const double p = a + 0.381966 * (b - a), q = a + 0.618034 * (b - a);
        const bool left = solve(model, width(p), samples, free_f90).residual <
                          solve(model, width(q), samples, free_f90).residual;
        (left ? b : a) = left ? q : p;
    }
    const double found = width(0.5 * (a + b));
    return {found, solve(model, found, samples, free_f90)};
}

Colour fitted(const Fit& fit, const Geometry& g) {
    const Basis b = basis(fit.model, fit.width, g);
    Colour f{};
    const double grazing = fit.model == FitModel::ggx_diffuse ? fit.f90 * b[2] : 0;
    for (std::size_t k = 0; k < 3; ++k) f[k] = fit.diffuse[k] * b[0] + fit.f0[k] * b[1] + grazing;
    return f;
}

void judge(Fit& fit, const std::vector<Sample>& samples, std::size_t lobes) {
    std::vector<double> off(lobes), all(lobes);
    for (const Sample& one : samples) {
        const Colour f = fitted(fit, one.geometry);
        for (std::size_t k = 0; k < 3; ++k) {
            off[one.lobe] += one.solid * std::abs(f[k] - one.f[k]);
            all[one.lobe] += one.solid * std::abs(one.f[k]);
        }
    }
    double off_sum = 0, all_sum = 0;
    for (std::size_t n = 0; n < lobes; ++n) {
        off_sum += off[n], all_sum += all[n];
        if (all[n] > 0) fit.error_worst = std::max(fit.error_worst, off[n] / all[n]);
    }
    fit.error = all_sum > 0 ? off_sum / all_sum : 0;
}

}  // namespace

std::string to_string(FitModel model) {
    return model == FitModel::ggx_diffuse ? "ggx_diffuse" : "lafortune_phong";
}

Colour fitted_value(const Fit& fit, double theta_in, Vec out) {
    return fitted(fit, geometry(theta_in, out));
}

Fit fit_model(FitModel model, const LobeTables& tables, Resampler& resampler) {
    constexpr std::size_t kLobesMax = 12;
    std::vector<Sample> samples;
    const std::size_t count = tables.measured.size(), step = (count + kLobesMax - 1) / kLobesMax;
    for (std::size_t n = 0; n < count; n += step)
        add_samples(std::min(tables.theta_in[tables.measured[n]], 88.0), n, tables, resampler,
                    samples);
    auto [width, linear] = best_width(model, samples, false);
    if (model == FitModel::ggx_diffuse) {
        constexpr double kMuchLess = 0.7;
        const auto [other_width, other] = best_width(model, samples, true);
        if (other.residual < kMuchLess * linear.residual) width = other_width, linear = other;
    }
    Fit fit;
    fit.model = model;
    fit.width = width;
    fit.f90 = linear.f90;
    for (std::size_t k = 0; k < 3; ++k) {
        fit.diffuse[k] = linear.x[k][0];
        fit.f0[k] = linear.x[k][1];
    }
    judge(fit, samples, count);
    return fit;
}

Table error_map(const Fit& fit, const LobeTables& tables, const std::vector<double>& theta_in,
                std::size_t width, std::size_t height, Resampler& resampler) {
    Table map{width, height * theta_in.size(), {"error"}, {{}}};
    for (const double theta : theta_in) {
        std::vector<Vec> out;
        for (std::size_t n = 0; n < width * height; ++n)
            out.push_back(from_mirror(theta, direction(180.0 * static_cast<double>(n / width) /
                                                           static_cast<double>(height - 1),
                                                       360.0 * static_cast<double>(n % width) /
                                                           static_cast<double>(width - 1))));
        const Sampled found = resampler.values(tables, theta, out);
        double most = 0;
        for (std::size_t n = 0; n < out.size(); ++n)
            most = std::max(most, static_cast<double>(found.g[n]));
        for (std::size_t n = 0; n < out.size(); ++n) {
            const bool judged = out[n].z > 1e-3 && found.origin[n] < 1.5f && most > 0;
            const double f = static_cast<double>(found.g[n]);
            const double error =
                judged ? (fitted_value(fit, theta, out[n])[1] - f) / (std::abs(f) + 0.01 * most)
                       : 0.0;
            map.planes[0].push_back(static_cast<float>(error));
        }
    }
    return map;
}

std::optional<Fit> offered(const LobeTables& tables, double error_asked, Resampler& resampler) {
    const Fit fit = fit_model(FitModel::ggx_diffuse, tables, resampler);
    if (fit.error_worst > error_asked) return std::nullopt;
    return fit;
}

}  // namespace kiln::measured
