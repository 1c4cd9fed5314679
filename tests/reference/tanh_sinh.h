// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <vector>

namespace kiln::reference {

/// Tanh-sinh (double exponential) rule on [0, 1], Takahasi and Mori 1974. A node is known by its
/// distance to both ends, so that an integrand that peaks or vanishes at an end loses no digit
/// there. Arrays are padded with zero weights to a multiple of kLanes.
struct TanhSinh {
    static constexpr std::size_t kLanes = 4;
    std::vector<double> from0, from1, weight;
    std::vector<double> half_cosine2;  ///< cos^2(pi from0 / 2): for an azimuth on [0, pi]
};

inline constexpr int kLowestLevel = 3;
inline constexpr int kHighestLevel = 9;

/// The rule with step 2^-level in the transformed variable, level in [kLowestLevel, kHighestLevel].
const TanhSinh& tanh_sinh(int level);

/// Raises the level until two in a row agree within `absolute + relative * |value|`, returns the
/// finer. One more level squares the error of this rule (an analytic integrand), so the difference
/// is the error of the coarser one and that of the finer is far below it. Throws std::domain_error
/// where none agree, at once where a sum is not finite.
template <class AtLevel, class Size>
auto converge(const AtLevel& at_level, double absolute, double relative, const Size& size,
              int first = kLowestLevel) {
    auto coarse = at_level(first);
    for (int level = first + 1; level <= kHighestLevel; ++level) {
        const auto fine = at_level(level);
        if (size(fine, coarse) <= absolute + relative * size(fine)) return fine;
        if (!std::isfinite(size(fine))) break;
        coarse = fine;
    }
    throw std::domain_error("reference quadrature: no two orders agree");
}

/// How large a number, or the difference of two, is for converge().
struct Magnitude {
    double operator()(double a, double b = 0) const { return std::abs(a - b); }
};

}  // namespace kiln::reference
