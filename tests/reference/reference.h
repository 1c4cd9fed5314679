// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <span>
#include <vector>

/// Deterministic double-precision quadrature of the isotropic GGX lobe: the yardstick of the tests.
/// Nothing here is shared with kernels/: other variables, other spellings, no sampling.
///
/// NoV = cos of the angle to the normal in [0, 1] (0 or >= 1e-9), alpha = GGX width in [0, 1]
/// (0 or >= 1e-9); alpha = 0 is the mirror, NoV = 0 the limit from above. Anything else, and an
/// integral whose orders do not come to agree, throws std::domain_error.
namespace kiln::reference {

/// Smith's joint masking-shadowing: 1/(1 + Lo + Li), or G1(o) G1(i).
enum class Masking { correlated, separable };

/// albedo(F0, F90) = F0 * scale + F90 * bias, under Schlick's Fresnel with exponent 5.
struct SplitSum {
    double scale;
    double bias;
};

/// E = integral of f cos over the hemisphere with F = 1. Absolute error <= 1e-13.
double directional_albedo(double NoV, double alpha, Masking masking);

/// The same number over half-vectors instead of reflected directions: a second opinion, some 40
/// times slower. Absolute error <= 1e-12; NoV = 0 and alpha = 0 throw, this form has no limit
/// there.
double directional_albedo_half_vector(double NoV, double alpha, Masking masking);

/// 1 - E without the subtraction. Relative error <= 1e-9 for NoV, alpha >= 1e-4 (0 gives the
/// limit).
double deficit(double NoV, double alpha, Masking masking);

/// Both terms of the split sum. Absolute error <= 1e-12 each.
SplitSum split_sum(double NoV, double alpha, Masking masking);

/// Integral of fresnel(VoH) f cos. Absolute error <= 1e-12 times the size of `fresnel`, which must
/// be smooth on (0, 1): a kink (total internal reflection) slows convergence until it throws.
double albedo_with_fresnel(double NoV, double alpha, Masking masking,
                           const std::function<double(double VoH)>& fresnel);

/// E_avg = 2 * integral of E NoV dNoV. Absolute error <= 1e-12.
double average_albedo(double alpha, Masking masking);

/// 1 - E_avg without the subtraction. Relative error <= 1e-8 for alpha >= 1e-4.
double average_deficit(double alpha, Masking masking);

enum class Quantity { scale, bias, directional, average, multiscatter };

/// A whole table, fast: values[row * NoV.size() + column] with row over alpha, column over NoV
/// ("average" repeats its value along the row). Absolute error <= 1e-9; multiscatter (= 1 - E) also
/// relative <= 1e-6. thread_count 0 = as many as the machine has.
std::vector<double> table(Quantity quantity, Masking masking, std::span<const double> NoV,
                          std::span<const double> alpha, unsigned thread_count = 0);

/// Both split-sum tables for the price of one; layout and accuracy as in table().
std::vector<SplitSum> split_sum_table(Masking masking, std::span<const double> NoV,
                                      std::span<const double> alpha, unsigned thread_count = 0);

}  // namespace kiln::reference
