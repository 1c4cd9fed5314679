// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>

#include "server/spec/job_spec.h"

namespace kiln {

/// The sums that kernels/integrand.h can make, by index; 1 << index is its KILN_TERM_ bit.
inline constexpr int kTermCount = 3;

/// A quantity as a linear combination of term means, over a view that is fixed by the texel or
/// averaged.
struct QuantityRow {
    bool averaged;                                ///< 2∫ … NoV dNoV: depends on roughness alone
    std::array<double, kTermCount> coefficients;  ///< of weight (E), fresnel (B), deficit (1 − E)
};

/// One row a quantity: what a new one adds.
constexpr QuantityRow quantity_row(Quantity quantity) {
    switch (quantity) {
        case Quantity::split_sum_scale:
            return {false, {1, -1, 0}};  // A = E − B
        case Quantity::split_sum_bias:
            return {false, {0, 1, 0}};
        case Quantity::directional_albedo:
            return {false, {1, 0, 0}};
        case Quantity::average_albedo:
            return {true, {1, 0, 0}};
        // ∫ f_ms NoL dω = 1 − E(NoV) exactly (Kulla, Conty 2017). Sampling f_ms by GGX half
        // vectors, as is often done, misses most of it at low roughness.
        case Quantity::multiscatter_albedo:
            return {false, {0, 0, 1}};
    }
    __builtin_unreachable();
}

constexpr int terms_of(Quantity quantity) {
    int terms = 0;
    for (int t = 0; t < kTermCount; ++t)
        if (quantity_row(quantity).coefficients[static_cast<std::size_t>(t)] != 0) terms |= 1 << t;
    return terms;
}

}  // namespace kiln
