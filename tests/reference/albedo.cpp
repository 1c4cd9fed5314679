// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <numbers>
#include <string>

#include "tests/reference/lobe.h"
#include "tests/reference/tanh_sinh.h"

namespace kiln::reference {
namespace {

constexpr double kPi = std::numbers::pi;
// A difference of 1e-10 between two levels leaves about its square in the finer one; what remains
// is the rounding of some hundred terms, about 1e-15.
constexpr double kAgreement = 1e-10;

/// One reflected elevation e_i beside the given e_o. With |o + i|^2 = y, the lobe over the azimuth
/// phi is (y / (p + q cos phi))^2 with p + q cos phi = y - k: everything follows from p -+ q and k.
struct Slice {
    double k;
    double p_minus_q;  ///< > 0: the peak of the lobe
    double p_plus_q;
    double q;
    double r;         ///< sqrt(p^2 - q^2)
    double jacobian;  ///< G2 / mu_o * dmu_i / de_i
};

class Reflected {
  public:
    Reflected(double NoV, double alpha, Masking masking)
        : alpha2_(alpha * alpha),
          one_minus_alpha2_((1 - alpha) * (1 + alpha)),
          masking_(masking),
          elevation_(std::asin(NoV)),
          colatitude_(std::acos(NoV)),
          o_(NoV, std::cos(elevation_), alpha2_) {}

    /// Sum over the reflected elevations of weight * slice_integral(slice), split at the mirror
    /// direction.
    template <class Sum, class SliceIntegral>
    Sum over_elevations(int level, Sum sum, const SliceIntegral& integral) const {
        const TanhSinh& rule = tanh_sinh(level);
        for (std::size_t j = 0; j < rule.weight.size(); ++j) {
            if (rule.weight[j] == 0) continue;
            if (elevation_ > 0) {
                const double e = elevation_ * rule.from0[j], gap = elevation_ * rule.from1[j];
                integral(sum, slice(e, colatitude_ + gap, gap / 2), elevation_ * rule.weight[j]);
            }
            if (colatitude_ > 0) {
                const double gap = colatitude_ * rule.from0[j], c = colatitude_ * rule.from1[j];
                integral(sum, slice(elevation_ + gap, c, gap / 2), colatitude_ * rule.weight[j]);
            }
        }
        return sum;
    }

    /// alpha^2 / (4 pi): what stands before the integral over elevation and azimuth.
    double factor() const { return alpha2_ / (4 * kPi); }

  private:
    Slice slice(double elevation, double colatitude, double half_gap) const {
        const double sin_h = std::sin((elevation + elevation_) / 2);
        const double cos_h = std::sin((colatitude + colatitude_) / 2);
        const double sin_d = std::sin(half_gap), cos_d = std::cos(half_gap);
        const double h2 = sin_h * sin_h, d2 = cos_d * cos_d;
        const Direction i(std::sin(elevation), std::sin(colatitude), alpha2_);
        Slice s{};
        s.k = 4 * one_minus_alpha2_ * h2 * d2;
        s.p_minus_q = 4 * h2 * (sin_d * sin_d + alpha2_ * d2);
        s.p_plus_q = 4 * d2 * (cos_h * cos_h + alpha2_ * h2);
        s.q = 2 * o_.s * i.s;
        s.r = std::sqrt(s.p_minus_q) * std::sqrt(s.p_plus_q);
        s.jacobian = joint_over_cosine(o_, i, masking_) * i.s;
        return s;
    }

    double alpha2_, one_minus_alpha2_;
    Masking masking_;
    double elevation_, colatitude_;
    Direction o_;
};

/// Integral of the lobe over the azimuth, in closed form.
double whole_circle(const Slice& s) {
    const double ratio = s.k / s.r;
    const double p = (s.p_minus_q + s.p_plus_q) / 2;
    return 2 * kPi * (1 + 2 * ratio + ratio * ratio * (p / s.r));
}

/// Integral of lobe * weights over the azimuth. The map p + q cos phi = r^2 / (p + q cos psi) (an
/// eccentric anomaly) flattens the peak at phi = pi; what it concentrates at psi = pi the rule
/// resolves.
SplitSum schlick_circle(const Slice& s, const TanhSinh& rule) {
    constexpr std::size_t lanes = TanhSinh::kLanes;
    std::array<double, lanes> all{}, grazing{};
    const double r2 = s.r * s.r;
    for (std::size_t j = 0; j < rule.weight.size(); j += lanes) {
        for (std::size_t l = 0; l < lanes; ++l) {
            const double u = s.p_minus_q + 2 * s.q * rule.half_cosine2[j + l];
            const double y = s.k + r2 / u;
            const double lobe = rule.weight[j + l] * y * y * u;
            const double m = 1 - 0.5 * std::sqrt(y);
            const double m2 = m * m;
            all[l] += lobe * (1 - m2 * m2 * m);
            grazing[l] += lobe * (m2 * m2 * m);
        }
    }
    const double scale = 2 * kPi / (r2 * s.r);
    return {scale * ((all[0] + all[1]) + (all[2] + all[3])),
            scale * ((grazing[0] + grazing[1]) + (grazing[2] + grazing[3]))};
}

double circle_under(const Slice& s, const TanhSinh& rule,
                    const std::function<double(double)>& fresnel) {
    double sum = 0;
    const double r2 = s.r * s.r;
    for (std::size_t j = 0; j < rule.weight.size(); ++j) {
        const double u = s.p_minus_q + 2 * s.q * rule.half_cosine2[j];
        const double y = s.k + r2 / u;
        // |o + i| / 2 is at most 1; rounding may add an ulp that a Fresnel formula need not take.
        sum += rule.weight[j] * y * y * u * fresnel(std::min(1.0, std::sqrt(y) / 2));
    }
    return 2 * kPi * sum / (r2 * s.r);
}

struct LargerOfTwo {
    double operator()(const SplitSum& a, const SplitSum& b = {0, 0}) const {
        return std::max(std::abs(a.scale - b.scale), std::abs(a.bias - b.bias));
    }
};

void check(double NoV, double alpha) {
    check_argument("NoV", NoV);
    check_argument("alpha", alpha);
}

}  // namespace

void check_argument(const char* name, double value) {
    if (value == 0 || (value >= 1e-9 && value <= 1)) return;
    throw std::domain_error("reference: " + std::string(name) + " = " + std::to_string(value) +
                            " is neither 0 nor in [1e-9, 1]");
}

double directional_albedo_to(double NoV, double alpha, Masking masking, double agreement) {
    check(NoV, alpha);
    if (alpha == 0) return 1;
    const Reflected lobe(NoV, alpha, masking);
    return converge(
        [&](int level) {
            return lobe.factor() *
                   lobe.over_elevations(level, 0.0, [](double& sum, const Slice& s, double weight) {
                       sum += weight * s.jacobian * whole_circle(s);
                   });
        },
        agreement, 0, Magnitude{});
}

SplitSum split_sum_to(double NoV, double alpha, Masking masking, double agreement) {
    check(NoV, alpha);
    if (alpha == 0) {
        const double bias = std::pow(1 - NoV, 5);
        return {1 - bias, bias};
    }
    const Reflected lobe(NoV, alpha, masking);
    return converge(
        [&](int level) {
            const TanhSinh& rule = tanh_sinh(level);
            SplitSum sum = lobe.over_elevations(
                level, SplitSum{0, 0}, [&](SplitSum& total, const Slice& s, double weight) {
                    const SplitSum circle = schlick_circle(s, rule);
                    total.scale += weight * s.jacobian * circle.scale;
                    total.bias += weight * s.jacobian * circle.bias;
                });
            return SplitSum{lobe.factor() * sum.scale, lobe.factor() * sum.bias};
        },
        agreement, 0, LargerOfTwo{});
}

double directional_albedo(double NoV, double alpha, Masking masking) {
    return directional_albedo_to(NoV, alpha, masking, kAgreement);
}

SplitSum split_sum(double NoV, double alpha, Masking masking) {
    return split_sum_to(NoV, alpha, masking, kAgreement);
}

double albedo_with_fresnel(double NoV, double alpha, Masking masking,
                           const std::function<double(double VoH)>& fresnel) {
    check(NoV, alpha);
    if (alpha == 0) return fresnel(NoV);
    const Reflected lobe(NoV, alpha, masking);
    return converge(
        [&](int level) {
            const TanhSinh& rule = tanh_sinh(level);
            return lobe.factor() * lobe.over_elevations(
                                       level, 0.0, [&](double& sum, const Slice& s, double weight) {
                                           sum +=
                                               weight * s.jacobian * circle_under(s, rule, fresnel);
                                       });
        },
        kAgreement, kAgreement, Magnitude{});
}

}  // namespace kiln::reference
