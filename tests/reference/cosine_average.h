// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <map>
#include <vector>

#include "tests/reference/tanh_sinh.h"

namespace kiln::reference {

/// 2 * integral over [0, 1] of albedo(mu) mu dmu, split at `kinks`, to 1e-8 where `albedo` is of
/// the order of 1 and as accurate. Asks for mu >= lowest only and leaves out lowest^2.
template <class Albedo>
double cosine_average(const Albedo& albedo, const std::vector<double>& kinks, double lowest) {
    std::vector<double> ends{0, 1};
    ends.insert(ends.end(), kinks.begin(), kinks.end());
    std::sort(ends.begin(), ends.end());
    std::map<double, double> known;  // a level's nodes are among the next one's
    const auto over_cosine = [&](int level) {
        const TanhSinh& rule = tanh_sinh(level);
        double sum = 0;
        for (std::size_t part = 0; part + 1 < ends.size(); ++part)
            for (std::size_t j = 0; j < rule.weight.size(); ++j) {
                const double length = ends[part + 1] - ends[part];
                const double mu = std::min(1.0, ends[part] + length * rule.from0[j]);
                // Some hundred nodes of an albedo of a few: less than 1e-8 is left out.
                if (length * rule.weight[j] * mu < 1e-11 || mu < lowest) continue;
                const auto found = known.try_emplace(mu, 0);
                if (found.second) found.first->second = albedo(mu);
                sum += length * rule.weight[j] * mu * found.first->second;
            }
        return 2 * sum;
    };
    // One level more squares the error.
    return converge(over_cosine, 1e-5, 0, Magnitude{});
}

}  // namespace kiln::reference
