// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cmath>

#include "tests/reference/reference.h"

namespace kiln::reference {

/// A direction as Smith's functions need it.
struct Direction {
    double mu;     ///< sine of the elevation = cosine to the normal
    double s;      ///< cosine of the elevation
    double reach;  ///< sqrt(mu^2 + alpha^2 s^2) = mu (1 + 2 Lambda)

    Direction(double mu_, double s_, double alpha2)
        : mu(mu_), s(s_), reach(std::sqrt(mu_ * mu_ + alpha2 * s_ * s_)) {}
};

/// G1(o) / mu_o, regular at mu_o = 0.
inline double masking_over_cosine(const Direction& o) { return 2 / (o.mu + o.reach); }

/// G2(o, i) / mu_o, regular at mu_o = 0; mu_i > 0.
inline double joint_over_cosine(const Direction& o, const Direction& i, Masking masking) {
    if (masking == Masking::separable)
        return masking_over_cosine(o) * i.mu * masking_over_cosine(i);
    return 2 / (o.reach + o.mu * (i.reach / i.mu));
}

/// Throws std::domain_error unless 0 or in [1e-9, 1].
void check_argument(const char* name, double value);

/// The inner tolerances of directional_albedo(), split_sum() and deficit(), for callers that trade
/// accuracy for speed: two orders must agree within `agreement`.
double directional_albedo_to(double NoV, double alpha, Masking masking, double agreement);
SplitSum split_sum_to(double NoV, double alpha, Masking masking, double agreement);
double deficit_to(double NoV, double alpha, Masking masking, double relative_agreement);

/// 1 - E by whichever of the two integrals gives the asked number of digits more cheaply.
double cheaper_deficit(double NoV, double alpha, Masking masking, double relative_agreement);

}  // namespace kiln::reference
