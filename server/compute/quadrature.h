// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <iterator>
#include <span>
#include <vector>

#include "server/compute/backend.h"

// Deterministic quadrature, see kernels/quadrature.h and kernels/quadrature_diffuse.h for the
// rules.
//
// Largest error of one order against order 40, both maskings, over a 256 x 256 table (NoV and
// roughness at texel centres, so alpha from 3.8e-6), in double; the deficit's is relative:
//   elevation, azimuth   nodes   E       B       deficit
//   4, 4                 52      3e-2    5e-2    1e-1
//   6, 5                 93      5e-3    2e-2    2e-2
//   8, 8                 184     4e-4    2e-3    3e-3
//   10, 10               280     2e-5    2e-4    6e-4
//   12, 12               396     3e-6    3e-5    2e-4
//   14, 14               532     4e-7    4e-6    3e-5
//   16, 16               688     5e-8    6e-7    6e-6
//   20, 20               1060    9e-10   1e-8    2e-7
//   28, 28               2044    4e-13   4e-11   7e-10
// In float, rounding adds up to 3e-7 to E and 7e-7 to B, and 7e-7 relative to the deficit.
//
// No view of that table has an NoV below 1.9e-3, where the same orders do less. From 1e-4 to
// there, alpha in [1e-4, 1]:
//   order       10      12      14      16      20      28      40
//   E           7e-4    2e-4    4e-5    1e-5    8e-7    4e-9    1e-12
//   B           5e-3    1e-3    4e-4    1e-4    7e-6    3e-8    2e-10
//   deficit     1e-2    3e-3    6e-4    2e-4    1e-5    7e-8    2e-11
//
// Other lobes under Schlick's term, NoV and alpha in [1e-4, 1], largest errors of E and B against
// order 160; the last column is GGX inside a dielectric of ior 0.01 to 0.99999:
//   order   ggx, other maskings   beckmann   charlie, neubelt   charlie, charlie   total reflection
//   16      5e-5                  1e-3       7e-2               6e-3               2e-2
//   28      8e-9                  4e-5       6e-4               6e-6               2e-5
//   40      1e-10                 4e-7       3e-6               2e-7               6e-8
//   56      4e-12                 3e-10      9e-9               1e-8               1e-9
//   80      1e-13                 2e-14      1e-10              1e-10              3e-10
//
// Diffuse lobes stay below the first table: at most 4e-2 at order 4, 2e-3 at 6, 1e-4 at 8, 7e-6 at
// 10, 9e-7 at 12, 1e-7 at 14, 2e-8 at 16, 9e-10 at 20, 4e-11 at 28 (the last six by
// oren_nayar_full; against order 112, NoV from 1e-4).
namespace kiln {

/// Nodes of one texel at an order: those inside, and those of all pieces of the elevation.
std::uint64_t quadrature_evaluations(const QuadratureKind& kind, QuadratureOrder order);

/// Whether 1 - E is integrated by itself, without the subtraction that would lose its digits, and 0
/// at alpha 0: of lobes under Smith's maskings.
bool integrates_deficit(const QuadratureKind& kind);

/// Parameters that the kind does not object to, for launches that compare devices.
QuadratureParameters any_quadrature_parameters(const QuadratureKind& kind);

/// (node, weight) of the Gauss-Legendre rule on [0, 1], of each of these counts in turn: by + - x /
/// and square roots alone, so the same on every machine. Error <= 2e-16.
std::vector<double> gauss_legendre(std::initializer_list<unsigned> counts);
/// Those that a launch of this order takes.
std::vector<double> quadrature_nodes(const QuadratureKind& kind, QuadratureOrder order);

/// The orders that are tried in turn, with the largest error of E and B in the table above.
struct QuadratureStep {
    QuadratureOrder order;
    double error;
};
inline constexpr QuadratureStep kQuadratureSteps[] = {
    {{4, 4}, 6e-2},    {{6, 5}, 2e-2},    {{8, 8}, 2e-3},     {{10, 10}, 2e-4},  {{12, 12}, 3e-5},
    {{14, 14}, 4e-6},  {{16, 16}, 6e-7},  {{20, 20}, 1e-8},   {{28, 28}, 1e-10}, {{40, 40}, 1e-12},
    {{56, 56}, 1e-12}, {{80, 80}, 1e-12}, {{112, 112}, 1e-12}};
/// The last one: where no two orders agree before it, the tolerance is out of reach.
inline constexpr std::size_t kQuadratureLast = std::size(kQuadratureSteps) - 1;

/// The first order to try for a tolerance: the one before the first that is known to come within
/// twice of it, so that two orders never agree by chance long before. For tolerances below 1e-7
/// that one itself: by then the error hardly changes its sign any more.
constexpr std::size_t quadrature_start(double tolerance) {
    const bool fine = tolerance < 1e-7;
    const double most = fine ? tolerance : 2 * tolerance;
    std::size_t step = 0;
    while (step + 1 < kQuadratureLast && kQuadratureSteps[step].error > most) ++step;
    return fine || step == 0 ? step : step - 1;
}

/// Relative errors of 1 - E count from here on: below it E is 1 to all digits of a double.
inline constexpr double kDeficitLeast = 1e-14;

/// Of a kind: other lobes than those of the first table need two steps more, Charlie's three,
/// and four where its masking is softened. With two, one in a hundred places of a softened one was
/// off by up to 9 tolerances of 5e-7, since two orders agreed by chance.
constexpr std::size_t quadrature_start(const QuadratureKind& kind, double tolerance) {
    const auto* lobe = std::get_if<LobeRule>(&kind.rule);
    const bool cloth = lobe && lobe->distribution == static_cast<int>(Distribution::charlie);
    const bool softened = lobe && lobe->masking == kCharlieSoftened;
    const std::size_t more = softened ? 4 : cloth ? 3 : lobe ? 2 : 0;
    return std::min(quadrature_start(tolerance) + more, kQuadratureLast - 1);
}
/// For a view: two steps more where the first table does not hold, or two orders that agree by
/// chance are off by 80 tolerances (NoV 1.2e-4, alpha .07). Below 1e-7 the steps there are enough.
constexpr std::size_t quadrature_start(const QuadratureKind& kind, double tolerance, double NoV) {
    const bool grazing =
        NoV < 1.9e-3 && tolerance >= 1e-7 && std::holds_alternative<SmithRule>(kind.rule);
    return quadrature_start(kind, tolerance) + (grazing ? 2 : 0);
}

/// What float arithmetic may add to a value beyond the rule's own error, as part of max(1, E).
inline constexpr double kQuadratureFloatRounding = 1e-6;
/// The same of a kind: Charlie's masking is exp L, L up to 20, and half a unit of that and of the
/// quotient that it starts with are 1e-6 each: 3.5e-6 with what the others add (3.32e-6 was seen).
double quadrature_float_rounding(const QuadratureKind& kind);

struct QuadratureTolerance {
    double absolute = 1e-9;       ///< of E and B, as part of max(1, E): Charlie's E has no bound
    double deficit_relative = 0;  ///< of 1 - E; 0: it is not asked for
};

/// Texels in the order of the request.
struct QuadratureResult {
    /// B is empty unless asked for. Of a diffuse lobe E is the albedo, and the deficit 0.
    std::vector<double> E, B, deficit;
    /// Difference of the last two orders, the larger of E's and B's: the error of the lower one,
    /// and a bound on that of the value. In float, quadrature_float_rounding comes on top.
    std::vector<float> error;
    std::vector<float> deficit_error;  ///< the same, relative
    std::vector<std::uint8_t> step;    ///< in kQuadratureSteps, of the order that gave the value
    std::uint64_t evaluations = 0;
    QuadratureOrder order_max;
    std::size_t unsettled = 0;  ///< texels whose error is still above the tolerance
    bool converged() const { return unsettled == 0; }
};

/// Where to integrate, NoV and alpha (of equal length) in [0, 1], and the numbers of the models.
struct QuadraturePlaces {
    std::span<const double> NoV, alpha;
    QuadratureParameters parameters{};
    /// In kQuadratureSteps: the orders to take, with no second one to compare with and no error
    /// (infinity). Empty: as many as they need.
    std::span<const std::uint8_t> steps{};
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
    std::vector<double> mean;  ///< at each alpha: 1 - E_avg, or the average diffuse albedo
    std::uint64_t evaluations = 0;
};

/// 2 * integral of 1 - E or a diffuse albedo, NoV dNoV, within `tolerance`; at 1e-9 the relative
/// error of 1 - E_avg is <= 1e-6 for alpha >= 1e-4 as well. `kind` is one of
/// quadrature_average_kind or of a diffuse lobe in double. `between` is called between launches and
/// may throw.
QuadratureAverages quadrature_averages(Backend& backend, const QuadratureKind& kind,
                                       const QuadratureParameters& parameters,
                                       std::span<const double> alpha, double tolerance,
                                       const std::function<void()>& between);
/// Of the deficit.
QuadratureKind quadrature_average_kind(const KernelMaterial& lobe);
/// Of a lobe (lobe_of() in plan.h) under a Fresnel term, with its parameters where it has one.
QuadratureKind quadrature_kind(const KernelMaterial& lobe, int fresnel,
                               const QuadratureParameters& parameters, Precision precision);

}  // namespace kiln
