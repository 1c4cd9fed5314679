// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cmath>
#include <complex>

// Fresnel's equations as textbooks write them, in extended precision: a complex index beside a
// medium of index 1, unpolarised light.
namespace textbook {

using Extended = long double;

inline Extended fresnel(std::complex<Extended> index, Extended cosine) {
    const std::complex<Extended> one = 1;
    const auto inside = std::sqrt(one - (one - cosine * cosine) / (index * index));
    const auto s = (cosine - index * inside) / (cosine + index * inside);
    const auto p = (index * cosine - inside) / (index * cosine + inside);
    return (std::norm(s) + std::norm(p)) / 2;
}

}  // namespace textbook
