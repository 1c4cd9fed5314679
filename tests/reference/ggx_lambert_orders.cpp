// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstddef>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "tests/reference/facet_rings.h"
#include "tests/reference/ggx_lambert.h"

namespace kiln::reference {
namespace {

constexpr double kPi = std::numbers::pi;

using Matrix = std::vector<double>;  // row after row

/// Directions by elevation: Gauss-Legendre over [0, pi/2], weights of d(cosine to the normal).
struct Ordinates {
    std::vector<double> cosine, sine, weight;
};

Ordinates gauss_legendre(int count) {
    Ordinates made;
    for (int i = 0; i < count; ++i) {
        double x = std::cos(kPi * (i + 0.75) / (count + 0.5)), slope = 1;
        for (int step = 0; step < 100; ++step) {
            double last = 1, value = x;
            for (int k = 2; k <= count; ++k) {
                const double next = ((2 * k - 1) * x * value - (k - 1) * last) / k;
                last = value;
                value = next;
            }
            slope = count * (x * value - last) / (x * x - 1);
            const double move = value / slope;
            x -= move;
            if (std::abs(move) < 1e-15) break;
        }
        const double e = kPi / 4 * (1 + x);
        made.cosine.push_back(std::sin(e));
        made.sine.push_back(std::cos(e));
        made.weight.push_back(kPi / 4 * 2 / ((1 - x * x) * slope * slope) * std::cos(e));
    }
    return made;
}

/// The half-space of the microsurface. In tau = -ln C1 of the height it is homogeneous: a ray going
/// down meets 1 + Lambda facets a unit, a ray going up Lambda (Heitz et al. 2016, section 4).
class HalfSpace {
  public:
    HalfSpace(double alpha, const std::vector<double>& views, int count)
        : alpha_(alpha), up_(gauss_legendre(count)), down_(up_) {
        for (const double NoV : views) {
            down_.cosine.push_back(NoV);
            down_.sine.push_back(std::sqrt((1 - NoV) * (1 + NoV)));
            down_.weight.push_back(0);
        }
        const auto lambda = [&](double c) { return smith_lambda(Distribution::ggx, alpha_, c); };
        for (const double c : up_.cosine) up_rate_.push_back(lambda(c));
        for (const double c : down_.cosine) down_rate_.push_back(1 + lambda(c));
        down_up_ = turns(down_, 1, up_, 1);
        down_down_ = turns(down_, 1, down_, -1);
        up_up_ = turns(up_, -1, up_, 1);
        up_down_ = turns(up_, -1, down_, -1);
    }

    /// Rows: shares[direction down][bounces - 1].
    std::vector<std::vector<double>> shares(int bounces) const {
        const std::size_t n = up_.cosine.size(), rows = down_.cosine.size();
        std::vector<Matrix> left;      // R_k: [down][up], density in the cosine of up
        std::vector<Matrix> returned;  // R_k, then one more facet that sends down again
        std::vector<std::vector<double>> result(rows);
        for (int k = 1; k <= bounces; ++k) {
            Matrix sum = k == 1 ? down_up_ : Matrix(rows * n);
            if (k > 1) {
                accumulate(sum, down_down_, down_.weight, left.back());
                accumulate(sum, left.back(), up_.weight, up_up_);
            }
            for (int j = 1; j + 2 <= k; ++j)
                accumulate(sum, returned[static_cast<std::size_t>(j - 1)], down_.weight,
                           left[static_cast<std::size_t>(k - 2 - j)]);
            for (std::size_t d = 0; d < rows; ++d) {
                double share = 0;
                for (std::size_t u = 0; u < n; ++u) {
                    sum[d * n + u] /= down_rate_[d] + up_rate_[u];
                    share += up_.weight[u] * sum[d * n + u];
                }
                result[d].push_back(share);
            }
            Matrix again(rows * rows);
            accumulate(again, sum, up_.weight, up_down_);
            left.push_back(std::move(sum));
            returned.push_back(std::move(again));
        }
        return result;
    }

  private:
    /// Facets met a unit of tau on a ray, times the density of the cosine in which they send it on.
    /// facing: 1 where the facets of rays from `from` are seen from above, `to` where they leave.
    Matrix turns(const Ordinates& from, int facing, const Ordinates& to, int leaving) const {
        Matrix matrix;
        const TanhSinh& rule = tanh_sinh(4);
        for (std::size_t i = 0; i < from.cosine.size(); ++i)
            for (std::size_t o = 0; o < to.cosine.size(); ++o) {
                const auto both = [&](double cos_m, double sin_m) {
                    return visible_cosine(facing * from.cosine[i], from.sine[i], cos_m, sin_m) *
                           visible_cosine(leaving * to.cosine[o], to.sine[o], cos_m, sin_m);
                };
                const auto slope = [](const Ordinates& d, std::size_t at) {
                    return d.sine[at] > 0 ? d.cosine[at] / d.sine[at] : 0;
                };
                matrix.push_back(over_normals(alpha_, {slope(from, i), slope(to, o)}, rule, both) /
                                 (kPi * from.cosine[i]));
            }
        return matrix;
    }

    /// to += a diag(weight) b.
    static void accumulate(Matrix& to, const Matrix& a, const std::vector<double>& weight,
                           const Matrix& b) {
        const std::size_t inner = weight.size(), rows = a.size() / inner, n = b.size() / inner;
        for (std::size_t i = 0; i < rows; ++i)
            for (std::size_t k = 0; k < inner; ++k) {
                const double factor = a[i * inner + k] * weight[k];
                if (factor == 0) continue;
                for (std::size_t j = 0; j < n; ++j) to[i * n + j] += factor * b[k * n + j];
            }
    }

    double alpha_;
    Ordinates up_, down_;
    std::vector<double> up_rate_, down_rate_;
    Matrix down_up_, down_down_, up_up_, up_down_;
};

}  // namespace

std::vector<std::vector<double>> ggx_lambert_shares(double alpha, const std::vector<double>& NoV,
                                                    int bounces, int ordinates) {
    if (!(alpha >= 1e-3 && alpha <= 1))
        throw std::domain_error("reference: alpha is not in [1e-3, 1]");
    for (const double cosine : NoV)
        if (!(cosine >= 1e-4 && cosine <= 1))
            throw std::domain_error("reference: NoV is not in [1e-4, 1]");
    const auto all = HalfSpace(alpha, NoV, ordinates).shares(bounces);
    return {all.end() - static_cast<std::ptrdiff_t>(NoV.size()), all.end()};
}

double ggx_lambert_albedo(const std::vector<double>& shares, double rho) {
    double sum = 0;
    for (std::size_t k = shares.size(); k-- > 0;) sum = rho * (shares[k] + sum);
    return sum;
}

std::vector<double> ggx_lambert_average_shares(double alpha, int bounces, int ordinates) {
    if (!(alpha >= 1e-3 && alpha <= 1))
        throw std::domain_error("reference: alpha is not in [1e-3, 1]");
    const Ordinates views = gauss_legendre(ordinates);
    const auto all = HalfSpace(alpha, {}, ordinates).shares(bounces);
    std::vector<double> average(static_cast<std::size_t>(bounces));
    for (std::size_t v = 0; v < all.size(); ++v)
        for (std::size_t k = 0; k < average.size(); ++k)
            average[k] += 2 * views.weight[v] * views.cosine[v] * all[v][k];
    return average;
}

}  // namespace kiln::reference
