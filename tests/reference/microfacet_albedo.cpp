// SPDX-License-Identifier: Apache-2.0
#include "tests/reference/microfacet_albedo.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "tests/reference/cosine_average.h"
#include "tests/reference/tanh_sinh.h"

namespace kiln::reference {
namespace {

constexpr double kPi = std::numbers::pi;
// One level more squares the error: a difference of 1e-6 leaves far less than 1e-9.
constexpr double kAgreement = 1e-6;

/// A variable v in which the half-vector's polar angle resolves the distribution.
struct PolarMap {
    bool wide;  ///< v is the angle itself; otherwise tan(theta) = alpha sinh v
    double alpha;

    double of_tangent(double tangent) const {
        return wide ? std::atan(tangent) : std::asinh(tangent / alpha);
    }
    double tangent(double v) const { return wide ? std::tan(v) : alpha * std::sinh(v); }
    double angle_per_v(double v, double tangent) const {
        return wide ? 1 : alpha * std::cosh(v) / (1 + tangent * tangent);
    }
};

/// Half-vectors h = (theta, phi) around V = (sin, 0, cos): VoH = cos(theta) NoV + sin(theta)
/// sin(V) cos(phi), NoL = 2 VoH cos(theta) - NoV, and dw_L = 4 VoH dw_h.
class OverHalfVectors {
  public:
    OverHalfVectors(const Microfacet& lobe, double NoV, const Fresnel& fresnel)
        : lobe_(lobe),
          fresnel_(fresnel),
          mu_(NoV),
          angle_(std::acos(NoV)),
          sine_(std::sin(angle_)),
          map_{lobe.distribution == Distribution::charlie, lobe.alpha},
          light_kinks_(visibility_kinks(lobe.visibility)) {
        find_polar_breaks();
    }

    double at(int level) const {
        const TanhSinh& rule = tanh_sinh(level);
        double sum = 0;
        for (std::size_t part = 0; part + 1 < breaks_.size(); ++part) {
            const double length = breaks_[part + 1] - breaks_[part];
            for (std::size_t j = 0; j < rule.weight.size(); ++j) {
                const double v = breaks_[part] + length * rule.from0[j];
                const double t = map_.tangent(v);
                const double weight = length * rule.weight[j] * map_.angle_per_v(v, t) *
                                      distribution(lobe_.distribution, lobe_.alpha, t);
                if (weight * t < 1e-18) continue;
                sum += weight * circle(t, rule);
            }
        }
        return sum;
    }

  private:
    /// Polar angles where a curve NoL = m or VoH = u begins, ends or meets another.
    void find_polar_breaks() {
        // Beckmann beyond 7 alpha: exp(-49) of nothing.
        double last = kPi / 4 + angle_ / 2;
        if (lobe_.distribution == Distribution::beckmann)
            last = std::min(last, std::atan(7 * lobe_.alpha));
        std::vector<double> angles;
        std::vector<double> light = light_kinks_;
        light.push_back(0);
        for (const double m : light) {
            angles.push_back((angle_ + std::acos(m)) / 2);
            angles.push_back(std::abs(angle_ - std::acos(m)) / 2);
            for (const double u : fresnel_.kinks)
                if (mu_ + m < 2 * u) angles.push_back(std::acos((mu_ + m) / (2 * u)));
        }
        for (const double u : fresnel_.kinks) {
            angles.push_back(std::acos(u) + angle_);
            angles.push_back(std::abs(std::acos(u) - angle_));
        }
        breaks_ = {0, map_.of_tangent(std::tan(last))};
        for (const double angle : angles)
            if (angle > 1e-12 && angle < last - 1e-12)
                breaks_.push_back(map_.of_tangent(std::tan(angle)));
        std::sort(breaks_.begin(), breaks_.end());
    }

    /// The azimuth where VoH = u, or the end beyond which it would lie.
    double azimuth(double u, double cos_h, double sin_h) const {
        const double cosine = (u - cos_h * mu_) / (sin_h * sine_);
        return std::acos(std::clamp(cosine, -1.0, 1.0));
    }

    /// Integral over the azimuth of F V NoL 4 VoH sin(theta).
    double circle(double t, const TanhSinh& rule) const {
        const double cos_h = 1 / std::sqrt(1 + t * t), sin_h = t * cos_h;
        const double horizon = azimuth(mu_ / (2 * cos_h), cos_h, sin_h);
        std::vector<double> ends{0, horizon};
        for (const double m : light_kinks_)
            ends.push_back(azimuth((mu_ + m) / (2 * cos_h), cos_h, sin_h));
        for (const double u : fresnel_.kinks) ends.push_back(azimuth(u, cos_h, sin_h));
        std::sort(ends.begin(), ends.end());
        double sum = 0;
        for (std::size_t part = 0; part + 1 < ends.size(); ++part) {
            if (ends[part] >= horizon) break;
            const double length = ends[part + 1] - ends[part];
            if (length <= 0) continue;
            for (std::size_t j = 0; j < rule.weight.size(); ++j) {
                const double phi = ends[part] + length * rule.from0[j];
                const double VoH = std::min(1.0, cos_h * mu_ + sin_h * sine_ * std::cos(phi));
                const double NoL = std::min(1.0, 2 * VoH * cos_h - mu_);
                if (NoL <= 0 || rule.weight[j] == 0) continue;
                sum += length * rule.weight[j] * fresnel_.at(VoH) * visibility(lobe_, mu_, NoL) *
                       NoL * VoH;
            }
        }
        return 2 * 4 * sin_h * sum;  // both halves of the circle
    }

    Microfacet lobe_;
    const Fresnel& fresnel_;
    double mu_, angle_, sine_;
    PolarMap map_;
    std::vector<double> light_kinks_;
    std::vector<double> breaks_;
};

void check(const Microfacet& lobe, double NoV) {
    check_lobe(lobe);
    if (!(NoV >= 1e-6 && NoV <= 1) || lobe.alpha < 1e-3)
        throw std::domain_error("reference: NoV is not in [1e-6, 1] or alpha below 1e-3");
}

/// F D V NoL at the light of elevation e and azimuth psi from the mirror direction's.
double towards_light(const Microfacet& lobe, const Fresnel& fresnel, double NoV, double e,
                     double psi) {
    const double sin_v = std::sqrt((1 - NoV) * (1 + NoV)), sin_l = std::cos(e), NoL = std::sin(e);
    const double x = sin_l * std::cos(psi) - sin_v, y = sin_l * std::sin(psi), z = NoL + NoV;
    const double length = std::sqrt(x * x + y * y + z * z);
    return fresnel.at(std::min(1.0, length / 2)) *
           distribution(lobe.distribution, lobe.alpha, std::sqrt(x * x + y * y) / z) *
           visibility(lobe, NoV, NoL) * NoL;
}

}  // namespace

double microfacet_albedo(const Microfacet& lobe, double NoV, const Fresnel& fresnel) {
    check(lobe, NoV);
    const OverHalfVectors integral(lobe, NoV, fresnel);
    return converge([&](int level) { return integral.at(level); }, kAgreement, 0, Magnitude{});
}

double microfacet_albedo_over_light(const Microfacet& lobe, double NoV, const Fresnel& fresnel) {
    check(lobe, NoV);
    std::vector<double> ends{0, std::asin(NoV), kPi / 2};
    for (const double kink : visibility_kinks(lobe.visibility)) ends.push_back(std::asin(kink));
    std::sort(ends.begin(), ends.end());
    const auto over_elevation = [&](int level) {
        const TanhSinh& rule = tanh_sinh(level);
        double sum = 0;
        for (std::size_t part = 0; part + 1 < ends.size(); ++part)
            for (std::size_t j = 0; j < rule.weight.size(); ++j) {
                const double length = ends[part + 1] - ends[part];
                const double e = ends[part] + length * rule.from0[j];
                const double weight = length * rule.weight[j] * std::cos(e);
                if (e <= 0 || weight < 1e-18) continue;
                for (std::size_t k = 0; k < rule.weight.size(); ++k)
                    sum += weight * kPi * rule.weight[k] *
                           towards_light(lobe, fresnel, NoV, e, kPi * rule.from0[k]);
            }
        return 2 * sum;
    };
    return converge(over_elevation, kAgreement, 0, Magnitude{});
}

double microfacet_average(const Microfacet& lobe, const Fresnel& fresnel) {
    check(lobe, 1);
    // V as a function of NoV has the kinks that it has as a function of NoL.
    return cosine_average([&](double mu) { return microfacet_albedo(lobe, mu, fresnel); },
                          visibility_kinks(lobe.visibility), 1e-6);
}

GeneralSplitSum microfacet_split_sum(const Microfacet& lobe, double NoV, double exponent) {
    return {microfacet_albedo(lobe, NoV, fresnel_schlick(1, 0, exponent)),
            microfacet_albedo(lobe, NoV, fresnel_schlick(0, 1, exponent))};
}

}  // namespace kiln::reference
