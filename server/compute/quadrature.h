// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "server/compute/backend.h"

// Deterministic quadrature, see kernels/quadrature.h for the rule.
//
// Largest error of one order against tests/reference, both maskings, in double; first over 241
// places with NoV, alpha in [1e-4, 1], then over a 256 x 256 table (NoV and roughness at texel
// centres, so alpha from 3.8e-6):
//   order   nodes   E                  B                  deficit, relative
//   14      532     2e-5     3e-7      3e-4     2e-5      4e-4     3e-5
//   20      1060    8e-7     8e-10     7e-6     7e-8      1e-5     2e-7
//   28      2044    3e-9     3e-13     2e-8     1e-9      4e-8     6e-10
//   40      4120    1e-12    2e-15     1e-10    3e-11     1e-11    < 6e-12
//   56      8008    < 3e-15            4e-12    6e-13     < 4e-12
// In float, rounding adds up to 3e-7 to E and 7e-7 to B, and 7e-7 relative to the deficit. A 256^2
// split-sum table to 1e-6 in float takes 1694 nodes a texel, of 18 ns for 16 lanes of AVX-512.
namespace kiln {

/// Nodes of one texel at an order: those inside, and those of the four pieces of the elevation.
constexpr std::uint64_t quadrature_evaluations(QuadratureOrder order, bool fresnel) {
    const std::uint64_t n = order.elevation, reflecting = 2 * n + n / 2;
    return reflecting * (fresnel ? 1 + std::uint64_t{order.azimuth} : 1) + n / 2;
}

/// (node, weight) of the Gauss-Legendre rule on [0, 1], of each of these counts in turn: by + - x /
/// and square roots alone, so the same on every machine. Error <= 2e-16.
std::vector<double> gauss_legendre(std::initializer_list<unsigned> counts);
/// Those that a launch of this order takes.
std::vector<double> quadrature_nodes(QuadratureOrder order);

/// The orders that are tried in turn, all even. Their errors fall like q^order, q = 0.5 to 0.7:
/// from one to the next by a factor of 40 and more wherever they are below 1e-3.
/// Tolerances below kQuadratureTight start at 28: by then the error hardly changes its sign any
/// more, where two orders would agree by chance.
inline constexpr QuadratureOrder kQuadratureOrders[] = {{14, 14}, {20, 20}, {28, 28},  {40, 40},
                                                        {56, 56}, {80, 80}, {112, 112}};
inline constexpr std::size_t kQuadratureTightStart = 2;
inline constexpr double kQuadratureTight = 1e-7;

/// What float arithmetic may add to a value beyond the rule's own error.
inline constexpr double kQuadratureFloatRounding = 1e-6;

struct QuadratureTolerance {
    double absolute = 1e-9;       ///< of E and B
    double deficit_relative = 0;  ///< of 1 - E; 0: it is not asked for
};

/// Texels in the order of the request.
struct QuadratureResult {
    std::vector<double> E, B, deficit;  ///< B is empty unless asked for
    /// Difference of the last two orders, the larger of E's and B's: the error of the lower one,
    /// and a bound on that of the value. In float, rounding adds at most kQuadratureFloatRounding.
    std::vector<float> error;
    std::vector<float> deficit_error;  ///< the same, relative
    std::uint64_t evaluations = 0;
    QuadratureOrder order_max;
    std::size_t unsettled = 0;  ///< texels whose error is still above the tolerance
    bool converged() const { return unsettled == 0; }
};

/// Where to integrate, NoV and alpha (of equal length) in [0, 1], and the Fresnel term's scalars.
struct QuadraturePlaces {
    std::span<const double> NoV, alpha;
    std::array<double, kFresnelParameters> parameters{};
};

/// Runs two orders and raises the order of those texels alone that do not agree, which go on
/// packed, until the error of all is within the tolerance or no order is left. In float, tolerances
/// below half the rounding count as that. Throws what the backend throws, and Error("non_finite").
QuadratureResult integrate_quadrature(Backend& backend, const QuadratureKind& kind,
                                      const QuadraturePlaces& places,
                                      const QuadratureTolerance& tolerance);

/// One place in double, with no backend.
struct QuadratureValue {
    double E = 0, B = 0, deficit = 0;
    double error = 0;          ///< as in QuadratureResult
    double deficit_error = 0;  ///< relative
    QuadratureOrder order;
};

/// E, B and 1 - E. Absolute error <= 1e-9 and relative error of the deficit <= 1e-6 for NoV, alpha
/// in [1e-4, 1]; 0 gives the limits (NoV = 0 from above; alpha = 0 the mirror).
QuadratureValue quadrature_albedo(double NoV, double alpha, Masking masking);

/// E alone, for a fiftieth of the price.
double quadrature_directional_albedo(double NoV, double alpha, Masking masking);
/// 1 - E alone, without the subtraction.
double quadrature_deficit(double NoV, double alpha, Masking masking);
struct QuadratureAverages {
    std::vector<double> deficit;  ///< 1 - E_avg at each alpha
    std::uint64_t evaluations = 0;
};

/// E_avg = 2 * integral of E NoV dNoV. Of 1 - E_avg the relative error is <= 1e-6 for alpha >=
/// 1e-4, the absolute error <= 1e-9. `between` is called between launches and may throw.
QuadratureAverages quadrature_averages(Backend& backend, Masking masking,
                                       std::span<const double> alpha,
                                       const std::function<void()>& between);
/// What its launches are specialised on.
QuadratureKind quadrature_average_kind(Masking masking);

}  // namespace kiln
