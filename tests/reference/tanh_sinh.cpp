// SPDX-License-Identifier: Apache-2.0
#include "tests/reference/tanh_sinh.h"

#include <array>
#include <numbers>

namespace kiln::reference {
namespace {

// Beyond |t| = 3.75 a node is within 1e-29 of an end and weighs less than 1e-27.
constexpr double kReach = 3.75;

TanhSinh make(int level) {
    TanhSinh rule;
    const double step = std::ldexp(1.0, -level);
    const int reach = static_cast<int>(kReach / step);
    for (int j = -reach; j <= reach; ++j) {
        const double t = j * step;
        const double w = std::numbers::pi / 2 * std::sinh(t);
        const double c = std::cosh(w);
        rule.from0.push_back(std::exp(w) / (2 * c));
        rule.from1.push_back(std::exp(-w) / (2 * c));
        rule.weight.push_back(step * std::numbers::pi / 4 * std::cosh(t) / (c * c));
    }
    while (rule.weight.size() % TanhSinh::kLanes != 0) {
        rule.from0.push_back(0.5);
        rule.from1.push_back(0.5);
        rule.weight.push_back(0);
    }
    for (const double distance : rule.from1) {
        const double sine = std::sin(std::numbers::pi / 2 * distance);
        rule.half_cosine2.push_back(sine * sine);
    }
    return rule;
}

}  // namespace

const TanhSinh& tanh_sinh(int level) {
    static const auto rules = [] {
        std::array<TanhSinh, kHighestLevel - kLowestLevel + 1> all;
        for (int l = kLowestLevel; l <= kHighestLevel; ++l)
            all[static_cast<std::size_t>(l - kLowestLevel)] = make(l);
        return all;
    }();
    return rules.at(static_cast<std::size_t>(level - kLowestLevel));
}

}  // namespace kiln::reference
