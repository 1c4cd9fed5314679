// SPDX-License-Identifier: Apache-2.0
#include "server/study/wide.h"

#include <cmath>

namespace kiln {

namespace wide {
using scalar = long double;
using real = long double;
inline real lane_sqrt(real x) { return std::sqrt(x); }
inline real lane_fma(real a, real b, real c) { return a * b + c; }
#define KILN_DOUBLE 1
#define KILN_LANES 1
#include "kernels/lane.h"
#undef K
#define K(literal) literal##L

#define KILN_TINY 3.4e-4932L
#define KILN_ROOT_TINY 1e-2400L
// In place of kernels/lane_math.h and lane_arc.h, which are fitted to float and double.
inline real lane_min(real a, real b) { return a > b ? b : a; }
inline real lane_max(real a, real b) { return a < b ? b : a; }
inline real lane_abs(real x) { return std::fabs(x); }
inline real lane_saturate(real x) { return lane_max(lane_min(x, 1), 0); }
inline real lane_exp(real x) { return std::exp(x); }
inline real lane_exp2(real x) { return std::exp2(x); }
inline real lane_exp_minus_square(real x) { return std::exp(-x * x); }
inline real lane_log2(real x) { return std::log2(x); }
inline real lane_pow(real x, real y) { return std::pow(x, y); }
inline real lane_pow_one_minus(real x, real y) { return std::exp(y * std::log1p(-x)); }
inline real lane_acos(real x) { return std::acos(x); }
inline real lane_asin(real x) { return std::asin(x); }
inline real lane_erfcx_deficit(real a) {
    return 1 - a * std::sqrt(std::acos(-1.0L)) * std::exp(a * a) * std::erfc(a);
}
// One function for every importance: GCC does not see that each reads what it wrote.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#include "kernels/models.h"
#pragma GCC diagnostic pop
#undef KILN_DOUBLE
#undef KILN_LANES
}  // namespace wide

long double wide_term(const KernelMaterial& material, std::size_t index, const WideInputs& at) {
    using namespace wide;
    const int terms = material.terms & 1 << index;
    if (!material.general) {
        const Integrand what = {material.masking, material.importance, terms};
        const Terms sum = batch_sum(what, 0, ggx_view(at.NoV, at.alpha), at.point.data(), 1);
        return index == kWeight ? sum.weight : index == kSchlick ? sum.fresnel : sum.deficit;
    }
    const Material what = {material.distribution, material.masking, material.importance, terms, 0,
                           material.fresnel,      material.diffuse};
    return material_sum(what, at.parameters.data(), at.NoV, at.alpha, at.point.data(), 0, 1)
        .term[index];
}

}  // namespace kiln
