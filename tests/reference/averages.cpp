// SPDX-License-Identifier: Apache-2.0
#include <numbers>

#include "tests/reference/lobe.h"
#include "tests/reference/tanh_sinh.h"

namespace kiln::reference {

double average_albedo(double alpha, Masking masking) {
    check_argument("alpha", alpha);
    if (alpha == 0) return 1;
    const auto over_elevation = [&](int level) {
        const TanhSinh& rule = tanh_sinh(level);
        double sum = 0;
        for (std::size_t j = 0; j < rule.weight.size(); ++j) {
            const double mu = std::sin(std::numbers::pi / 2 * rule.from0[j]);
            const double s = std::sin(std::numbers::pi / 2 * rule.from1[j]);
            // Below 1e-9 the integrand mu E weighs nothing, and the albedo refuses.
            if (mu < 1e-9 || rule.weight[j] * s < 1e-17) continue;
            sum += rule.weight[j] * mu * s * directional_albedo(mu, alpha, masking);
        }
        return std::numbers::pi * sum;
    };
    return converge(over_elevation, 1e-9, 0, Magnitude{});
}

double average_deficit(double alpha, Masking masking) {
    check_argument("alpha", alpha);
    if (alpha == 0) return 0;
    // mu = alpha sinh w: the deficit changes at mu ~ alpha and falls like (alpha / mu)^2 beyond.
    const double reach = std::asinh(1 / alpha);
    const auto over_w = [&](int level) {
        const TanhSinh& rule = tanh_sinh(level);
        double sum = 0;
        for (std::size_t j = 0; j < rule.weight.size(); ++j) {
            const double w = reach * rule.from0[j];
            const double mu = std::min(1.0, alpha * std::sinh(w));
            if (mu < 1e-9 || rule.weight[j] < 1e-16) continue;
            sum += rule.weight[j] * mu * alpha * std::cosh(w) *
                   cheaper_deficit(mu, alpha, masking, 1e-7);
        }
        return 2 * reach * sum;
    };
    return converge(over_w, 0, 1e-6, Magnitude{});
}

}  // namespace kiln::reference
