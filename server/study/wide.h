// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstddef>

#include "server/compute/native_group.h"
#include "server/compute/points.h"
#include "server/compute/terms.h"

namespace kiln {

/// What one sample of a kernel reads.
struct WideInputs {
    long double NoV = 1, alpha = 1;
    std::array<long double, kPointScalars> point{};
    std::array<long double, kParameterCount> parameters{};
};

/// The term `index` of that sample (Term in server/compute/terms.h) by the kernels' own text in
/// long double, with the C library's elementary functions: what float and double are held against.
/// Relative error some 1e-18 times what the formulas amplify (x86-64: a mantissa of 64 bits).
long double wide_term(const KernelMaterial& material, std::size_t index, const WideInputs& at);

}  // namespace kiln
