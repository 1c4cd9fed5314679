// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "tests/reference/cosine_average.h"
#include "tests/reference/diffuse_models.h"
#include "tests/reference/tanh_sinh.h"

namespace kiln::reference {
namespace {

constexpr double kPi = std::numbers::pi;

/// Light directions by elevation e and azimuth phi from V's.
class OverLight {
  public:
    OverLight(const Diffuse& lobe, double NoV, const DiffuseWeight& weight)
        : lobe_(lobe),
          weight_(weight),
          mu_(NoV),
          sine_(std::sqrt((1 - NoV) * (1 + NoV))),
          clamped_(lobe.model == DiffuseModel::chan2018),
          ends_{0, std::asin(NoV), kPi / 2} {
        const double polar = std::acos(NoV);
        for (const double u : weight.kinks) {
            const double across = 2 * std::acos(u);
            // Where the circle of directions at VoH = u first and last meets an azimuth of 0 or pi.
            for (const double theta : {std::abs(across - polar), across + polar})
                if (theta < kPi / 2) ends_.push_back(kPi / 2 - theta);
        }
        for (const double kink : weight.light_kinks) ends_.push_back(std::asin(kink));
        if (clamped_)
            for (const double cos_phi : {1.0, -1.0}) find_clamp(cos_phi);
        std::sort(ends_.begin(), ends_.end());
    }

    double at(int level) const {
        const TanhSinh& rule = tanh_sinh(level);
        double sum = 0;
        for (std::size_t part = 0; part + 1 < ends_.size(); ++part) {
            const double length = ends_[part + 1] - ends_[part];
            if (length <= 0) continue;
            for (std::size_t j = 0; j < rule.weight.size(); ++j) {
                const double e = ends_[part] + length * rule.from0[j];
                const double NoL = std::sin(e);
                const double w = length * rule.weight[j] * NoL * std::cos(e);
                if (w < 1e-18) continue;
                sum += w * half_circle(NoL, rule);
            }
        }
        return 2 * sum;
    }

  private:
    double above_clamp(double NoL, double cos_phi) const {
        return diffuse_brdf({DiffuseModel::chan2018_no_clamp, lobe_.roughness, 1}, mu_, NoL,
                            cos_phi) -
               1;
    }

    /// Elevations where the clamp of chan2018 begins or ends at this azimuth.
    void find_clamp(double cos_phi) {
        constexpr int kScan = 512;
        const auto excess = [&](double e) { return above_clamp(std::sin(e), cos_phi); };
        for (int i = 0; i < kScan; ++i) {
            const double e0 = kPi / 2 * (i + 0.01) / (kScan + 1), e1 = e0 + kPi / 2 / (kScan + 1);
            if ((excess(e0) > 0) != (excess(e1) > 0)) ends_.push_back(bisect(excess, e0, e1));
        }
    }

    template <class Function>
    static double bisect(const Function& function, double low, double high) {
        const bool positive = function(low) > 0;
        for (int i = 0; i < 60; ++i) {
            const double middle = (low + high) / 2;
            ((function(middle) > 0) == positive ? low : high) = middle;
        }
        return (low + high) / 2;
    }

    /// Integral of f weight over half the circle.
    double half_circle(double NoL, const TanhSinh& rule) const {
        std::vector<double> ends{0, kPi / 2, kPi};
        const double sines = sine_ * std::sqrt((1 - NoL) * (1 + NoL));
        for (const double u : weight_.kinks) {
            const double cosine = (2 * u * u - 1 - mu_ * NoL) / sines;
            if (std::abs(cosine) < 1) ends.push_back(std::acos(cosine));
        }
        if (clamped_ && (above_clamp(NoL, 1) > 0) != (above_clamp(NoL, -1) > 0))
            ends.push_back(
                bisect([&](double phi) { return above_clamp(NoL, std::cos(phi)); }, 0.0, kPi));
        std::sort(ends.begin(), ends.end());
        double sum = 0;
        for (std::size_t part = 0; part + 1 < ends.size(); ++part) {
            const double length = ends[part + 1] - ends[part];
            for (std::size_t j = 0; j < rule.weight.size(); ++j) {
                const double cos_phi = std::cos(ends[part] + length * rule.from0[j]);
                const double VoH = std::sqrt(std::max(0.0, (1 + mu_ * NoL + sines * cos_phi) / 2));
                sum += length * rule.weight[j] * diffuse_brdf(lobe_, mu_, NoL, cos_phi) *
                       weight_.at(NoL, std::min(1.0, VoH));
            }
        }
        return sum;
    }

    Diffuse lobe_;
    const DiffuseWeight& weight_;
    double mu_, sine_;
    bool clamped_;
    std::vector<double> ends_;
};

}  // namespace

double diffuse_integral(const Diffuse& lobe, double NoV, const DiffuseWeight& weight) {
    if (!(NoV >= 1e-5 && NoV <= 1)) throw std::domain_error("reference: NoV is not in [1e-5, 1]");
    const OverLight integral(lobe, NoV, weight);
    return converge([&](int level) { return integral.at(level); }, 1e-6, 0, Magnitude{});
}

double diffuse_albedo(const Diffuse& lobe, double NoV) {
    return diffuse_integral(lobe, NoV, {[](double, double) { return 1.0; }, {}, {}});
}

double diffuse_average(const Diffuse& lobe) {
    return cosine_average([&](double mu) { return diffuse_albedo(lobe, mu); }, {}, 1e-5);
}

}  // namespace kiln::reference
