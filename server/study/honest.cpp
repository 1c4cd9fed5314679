// SPDX-License-Identifier: Apache-2.0
#include "server/study/honest.h"

#include <cmath>

#include "server/study/host_albedo.h"

namespace kiln {

double f_quantile(double numerator, double denominator, double probability) {
    // P(F > x) is the regularised incomplete beta function at d / (d + n x): Abramowitz, Stegun
    // 1964, eq. 26.6.2.
    const double a = 0.5 * denominator, b = 0.5 * numerator;
    const auto density = [&](double t) { return std::pow(t, a - 1) * std::pow(1 - t, b - 1); };
    const auto beyond = [&](double x) {
        const double to = denominator / (denominator + numerator * x);
        return adaptive_integral(density, 0, to, 1e-13) / std::beta(a, b);
    };
    double low = 0, high = 1;
    while (beyond(high) > probability) high *= 2;
    for (int i = 0; i < 60; ++i) {
        const double middle = 0.5 * (low + high);
        (beyond(middle) > probability ? low : high) = middle;
    }
    return high;
}

double honest_ratio(std::size_t runs, std::size_t replicates, std::size_t points) {
    constexpr double kStudies = 0.05;
    const double each = -std::expm1(std::log1p(-kStudies) / static_cast<double>(points));
    const auto n = static_cast<double>(runs);
    return std::sqrt(f_quantile(n, n * static_cast<double>(replicates - 1), each));
}

}  // namespace kiln
