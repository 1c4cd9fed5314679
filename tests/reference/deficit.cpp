// SPDX-License-Identifier: Apache-2.0
#include <numbers>

#include "tests/reference/lobe.h"
#include "tests/reference/tanh_sinh.h"

namespace kiln::reference {
namespace {

constexpr double kPi = std::numbers::pi;

/// Distance of sinh(a) to sinh(b) from gap = a - b, without cancellation.
double sinh_gap(double a, double b, double gap) {
    return 2 * std::cosh((a + b) / 2) * std::sinh(gap / 2);
}

/// Which part of the half-vectors' weight is summed over the directions above the horizon.
enum class Part { reflected, shadowed };  // G2, or G1 - G2

/// Half-vectors (theta, phi) around o with t = tan(theta) = alpha sinh v, phi from o's azimuth:
/// D cos(theta) dw = sinh v / (pi cosh^3 v) dv dphi; G1(o) (o.h) / (mu cos(theta)) integrates to 1
/// over o.h > 0.
class HalfVectors {
  public:
    HalfVectors(double NoV, double alpha, Masking masking)
        : alpha_(alpha),
          alpha2_(alpha * alpha),
          masking_(masking),
          o_(NoV, std::cos(std::asin(NoV)), alpha2_),
          t_full_(NoV / (1 + o_.s)),
          t_end_(1 / t_full_),
          v_full_(std::asinh(t_full_ / alpha)),
          v_end_(std::asinh(t_end_ / alpha)) {}

    double above_horizon(int level, Part part) const {
        const TanhSinh& rule = tanh_sinh(level);
        double sum = 0;
        for (std::size_t j = 0; j < rule.weight.size(); ++j) {
            const double v = v_full_ * rule.from0[j];
            sum += v_full_ * rule.weight[j] * density(v) *
                   full_circle(v, v_full_ * rule.from1[j], rule, part);
            const double length = v_end_ - v_full_;
            if (length <= 0) continue;
            const double gap = length * rule.from0[j], rest = length * rule.from1[j];
            sum += length * rule.weight[j] * density(v_full_ + gap) *
                   cut_circle(v_full_ + gap, gap, rest, rule, part);
        }
        return 2 / kPi * sum;
    }

    /// What leaves towards o.i below the horizon: G1(o) over o.h > 0, mu_i < 0, phi in closed form.
    double lost(int level) const {
        const double t_half =
            o_.s > 0 ? o_.mu / o_.s : HUGE_VAL;  // o.h > 0 for every phi up to here
        double sum = 0;
        if (t_half < t_end_) {
            const double v_half = std::asinh(t_half / alpha_);
            sum +=
                lost_below(level, v_full_, v_half, false) + lost_below(level, v_half, v_end_, true);
        } else {
            sum += lost_below(level, v_full_, v_end_, false);
            sum += kPi * o_.mu * alpha2_ / 2 *
                   (1 / (alpha2_ + t_end_ * t_end_) - 1 / (alpha2_ + t_half * t_half));
        }
        if (o_.s > 0) sum += lost_tail(level, t_half, std::max(t_half, t_end_));
        return 2 / kPi * masking_over_cosine(o_) * sum;
    }

  private:
    static double density(double v) {
        const double c = std::cosh(v);
        return std::tanh(v) / (c * c);
    }

    /// Weight of one half-vector, given the reflected direction's cosine.
    double weight(double mu_i, double t, double cos_phi, double sin_phi, Part part) const {
        const double x = (mu_i + o_.mu) * t * cos_phi - o_.s, y = (mu_i + o_.mu) * t * sin_phi;
        const double s2 =
            x * x + y * y;  // sine^2 of the reflected direction, exact near the normal
        const Direction i(mu_i, std::sqrt(s2), alpha2_);
        const double oh_over_cos = (mu_i + o_.mu) * (1 + t * t) / 2;
        if (part == Part::reflected) return oh_over_cos * joint_over_cosine(o_, i, masking_);
        const double hidden = alpha2_ * s2 / (2 * (i.mu + i.reach));  // mu_i Lambda_i
        const double share =
            masking_ == Masking::separable
                ? hidden / (i.mu + hidden)
                : o_.mu * hidden / (i.mu * (o_.mu + o_.reach) / 2 + o_.mu * hidden);
        return oh_over_cos * masking_over_cosine(o_) * share;
    }

    /// theta below half the elevation of o: every phi reflects above the horizon. rest = v_full -
    /// v.
    double full_circle(double v, double rest, const TanhSinh& rule, Part part) const {
        const double t = alpha_ * std::sinh(v);
        const double cos2 = 1 / (1 + t * t);
        const double lowest = 2 * cos2 / (1 + t_full_ * t_full_) * alpha_ *
                              sinh_gap(v_full_, v, rest) * (1 + t * t_full_);
        double sum = 0;
        for (std::size_t j = 0; j < rule.weight.size(); ++j) {
            const double half = rule.half_cosine2[j];
            const double cos_phi = 2 * half - 1, sin_phi = 2 * std::sqrt(half * (1 - half));
            const double mu_i = lowest + 4 * o_.s * t * cos2 * half;
            sum += rule.weight[j] * weight(mu_i, t, cos_phi, sin_phi, part);
        }
        return kPi * sum;
    }

    /// cot^2(phi_m / 2) where the reflected direction meets the horizon; gap = v - v_full, rest =
    /// v_end - v.
    double horizon(double v, double gap, double rest) const {
        const double t = alpha_ * std::sinh(v);
        return alpha_ * sinh_gap(v, v_full_, gap) * (1 + t * t_full_) /
               ((t + t_full_) * t_full_ * alpha_ * sinh_gap(v_end_, v, rest));
    }

    double cut_circle(double v, double gap, double rest, const TanhSinh& rule, Part part) const {
        const double t = alpha_ * std::sinh(v);
        const double cot = std::sqrt(horizon(v, gap, rest));
        const double phi_m = 2 * std::atan(1 / cot), beyond = 2 * std::atan(cot);
        double sum = 0;
        for (std::size_t j = 0; j < rule.weight.size(); ++j) {
            const double half_gap = phi_m * rule.from1[j] / 2;
            const double mean = phi_m < kPi / 2 ? phi_m - half_gap : beyond + half_gap;
            const double mu_i = 4 * o_.s * t / (1 + t * t) * std::sin(half_gap) * std::sin(mean);
            const double phi = phi_m * rule.from0[j];
            sum += rule.weight[j] * weight(mu_i, t, std::cos(phi), std::sin(phi), part);
        }
        return phi_m * sum;
    }

    /// Lost part between two values of v at or below v_end; `facing` where o.h > 0 cuts phi too.
    double lost_below(int level, double v0, double v1, bool facing) const {
        if (v1 <= v0) return 0;
        const TanhSinh& rule = tanh_sinh(level);
        double sum = 0;
        for (std::size_t j = 0; j < rule.weight.size(); ++j) {
            const double gap = (v1 - v0) * rule.from0[j], rest = (v1 - v0) * rule.from1[j];
            const double v = v0 + gap, t = alpha_ * std::sinh(v);
            const double cot = std::sqrt(horizon(v, (v0 - v_full_) + gap, (v_end_ - v1) + rest));
            const double beyond = 2 * std::atan(cot);  // pi - phi_m
            double arc = o_.mu * beyond - o_.s * t * std::sin(beyond);
            if (facing) {
                const double past = alpha_ * sinh_gap(v, v0, gap);
                const double back = 2 * std::atan(std::sqrt(past / (t + o_.mu / o_.s)));
                arc -= o_.mu * back - o_.s * t * std::sin(back);
            }
            sum += (v1 - v0) * rule.weight[j] * density(v) * arc;
        }
        return sum;
    }

    /// Lost part beyond both limits, t = t_last / x, where every phi with o.h > 0 is lost.
    double lost_tail(int level, double t_half, double t_last) const {
        const TanhSinh& rule = tanh_sinh(level);
        double sum = 0;
        for (std::size_t j = 0; j < rule.weight.size(); ++j) {
            const double x = rule.from0[j], t = t_last / x;
            const double past = (t_last - t_half) + t_last * rule.from1[j] / x;
            const double phi = kPi - 2 * std::atan(std::sqrt(past / (t + t_half)));
            const double scale = alpha2_ * x * x + t_last * t_last;
            sum += rule.weight[j] * alpha2_ * t_last * t_last * x / (scale * scale) *
                   (o_.mu * phi + o_.s * t * std::sin(phi));
        }
        return sum;
    }

    double alpha_, alpha2_;
    Masking masking_;
    Direction o_;
    double t_full_,
        t_end_;  ///< tan of half the elevation of o, and its inverse: no phi reflects beyond
    double v_full_, v_end_;
};

}  // namespace

double directional_albedo_half_vector(double NoV, double alpha, Masking masking) {
    check_argument("NoV", NoV);
    check_argument("alpha", alpha);
    if (NoV == 0 || alpha == 0)
        throw std::domain_error("reference: the half-vector form needs NoV > 0 and alpha > 0");
    const HalfVectors half(NoV, alpha, masking);
    return converge([&](int level) { return half.above_horizon(level, Part::reflected); }, 1e-9, 0,
                    Magnitude{});
}

double deficit_to(double NoV, double alpha, Masking masking, double relative_agreement) {
    check_argument("NoV", NoV);
    check_argument("alpha", alpha);
    if (alpha == 0) return 0;
    // At NoV = 0 the correlated lobe loses nothing, and the separable one so much that 1 - E has
    // all digits.
    if (NoV == 0)
        return masking == Masking::correlated ? 0 : 1 - directional_albedo(NoV, alpha, masking);
    const HalfVectors half(NoV, alpha, masking);
    return converge(
        [&](int level) { return half.above_horizon(level, Part::shadowed) + half.lost(level); }, 0,
        relative_agreement, Magnitude{});
}

double deficit(double NoV, double alpha, Masking masking) {
    return deficit_to(NoV, alpha, masking, 1e-7);
}

double cheaper_deficit(double NoV, double alpha, Masking masking, double relative_agreement) {
    const double subtracted = 1 - directional_albedo(NoV, alpha, masking);
    // The albedo is good to 1e-13, so the difference to ten digits from 1e-3 on.
    if (subtracted > 1e-3) return subtracted;
    return deficit_to(NoV, alpha, masking, relative_agreement);
}

}  // namespace kiln::reference
