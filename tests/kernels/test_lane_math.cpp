// SPDX-License-Identifier: Apache-2.0
// Each function against the C library in long double, in units in the last place of the right
// value.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <type_traits>
#include <vector>

#include "tests/kernels/one_lane.h"

namespace {

using Wide = long double;

/// The kernels' functions at one lane of T.
template <class T>
struct Lane;
#define KILN_LANE_OF(T, where)                                                       \
    template <>                                                                      \
    struct Lane<T> {                                                                 \
        static T exp2(T x) { return where::lane_exp2(x); }                           \
        static T exp(T x) { return where::lane_exp(x); }                             \
        static T gauss(T x) { return where::lane_exp_minus_square(x); }              \
        static T log2(T x) { return where::lane_log2(x); }                           \
        static T pow(T x, T y) { return where::lane_pow(x, y); }                     \
        static T pow_one_minus(T x, T y) { return where::lane_pow_one_minus(x, y); } \
        static T erfcx_deficit(T x) { return where::lane_erfcx_deficit(x); }         \
        static T acos(T x) { return where::lane_acos(x); }                           \
        static T asin(T x) { return where::lane_asin(x); }                           \
        static T saturate(T x) { return where::lane_saturate(x); }                   \
        static T abs(T x) { return where::lane_abs(x); }                             \
        static T min(T x, T y) { return where::lane_min(x, y); }                     \
        static T max(T x, T y) { return where::lane_max(x, y); }                     \
    };
KILN_LANE_OF(float, in_float)
KILN_LANE_OF(double, in_double)
#undef KILN_LANE_OF

/// |got − right| in units of the last place of `right`; infinite where `got` is no number.
template <class T>
Wide ulps(T got, Wide right) {
    if (!std::isfinite(got)) return std::numeric_limits<Wide>::infinity();
    int exponent;
    std::frexp(right, &exponent);
    const int place = std::max(exponent, std::numeric_limits<T>::min_exponent);
    return std::abs(got - right) / std::ldexp(Wide(1), place - std::numeric_limits<T>::digits);
}

/// A dense walk and random points over [a, b], both ends among them.
template <class T>
std::vector<T> arguments(T a, T b) {
    constexpr int kSteps = 200000;
    std::vector<T> out = {a, b, std::nextafter(a, b), std::nextafter(b, a)};
    std::mt19937_64 random(7);
    std::uniform_real_distribution<T> any(a, b);
    for (int i = 1; i < kSteps; ++i) {
        out.push_back(static_cast<T>(Wide(a) + (Wide(b) - Wide(a)) * i / kSteps));
        out.push_back(any(random));
    }
    return out;
}

/// The worst error of f against `right` over the arguments.
template <class T, class F, class Right>
Wide worst(const std::vector<T>& arguments, F f, Right right) {
    Wide error = 0;
    for (const T x : arguments) error = std::max(error, ulps(f(x), right(Wide(x))));
    return error;
}

template <class T>
class LaneMath : public ::testing::Test {
  protected:
    static constexpr bool kDouble = std::is_same_v<T, double>;
    static constexpr T kInfinity = std::numeric_limits<T>::infinity();
    static constexpr T kNaN = std::numeric_limits<T>::quiet_NaN();
    static constexpr T kTiny = std::numeric_limits<T>::min();
    static constexpr T kHuge = std::numeric_limits<T>::max();
    static constexpr T kExponents = std::numeric_limits<T>::max_exponent;
};
using Precisions = ::testing::Types<float, double>;
TYPED_TEST_SUITE(LaneMath, Precisions);

// Half an ulp is the last rounding. The product before it weighs at most 0.41 of the result and its
// two roundings add 0.3 · 2^-p of it: another 0.3 ulp for a result at the low end of its binade.
TYPED_TEST(LaneMath, PowersOfTwo) {
    using T = TypeParam;
    using L = Lane<T>;
    const auto right = [](Wide x) { return std::exp2(x); };
    const T end = std::nextafter(TestFixture::kExponents, T(0));
    EXPECT_LE(worst(arguments<T>(3 - TestFixture::kExponents, end), L::exp2, right), 1.0L);
    EXPECT_LE(worst(arguments<T>(-1, 1), L::exp2, right), 1.0L);
    for (int n = 3 - int(TestFixture::kExponents); n < int(TestFixture::kExponents); ++n)
        EXPECT_EQ(L::exp2(T(n)), std::ldexp(T(1), n));
}

TYPED_TEST(LaneMath, PowersOfTwoEndInZeroInfinityAndNaN) {
    using T = TypeParam;
    using L = Lane<T>;
    const T infinity = TestFixture::kInfinity, most = TestFixture::kExponents;
    for (const T x : {most, most + 1, T(1e6), T(1e30), TestFixture::kHuge, infinity})
        EXPECT_EQ(L::exp2(x), infinity) << x;
    for (const T x : {std::nextafter(3 - most, -infinity), -most, T(-1e6), -TestFixture::kHuge})
        EXPECT_EQ(L::exp2(x), T(0)) << x;
    EXPECT_EQ(L::exp2(-infinity), T(0));
    EXPECT_EQ(L::exp(-infinity), T(0));
    EXPECT_EQ(L::exp(infinity), infinity);
    EXPECT_EQ(L::gauss(infinity), T(0));
    EXPECT_EQ(L::gauss(TestFixture::kHuge), T(0));
    for (const auto f : {L::exp2, L::exp, L::gauss, L::log2, L::acos, L::asin, L::erfcx_deficit,
                         L::saturate, L::abs})
        EXPECT_TRUE(std::isnan(f(TestFixture::kNaN)));
    EXPECT_TRUE(std::isnan(L::pow(TestFixture::kNaN, 2)));
    EXPECT_TRUE(std::isnan(L::pow(2, TestFixture::kNaN)));
}

// As for powers of two: the exponent comes in two parts and adds next to nothing.
TYPED_TEST(LaneMath, Exponentials) {
    using T = TypeParam;
    using L = Lane<T>;
    const T low = TestFixture::kDouble ? T(-707.7) : T(-86.64);
    const T high = TestFixture::kDouble ? T(709.78) : T(88.72);
    const auto exp = [](Wide x) { return std::exp(x); };
    EXPECT_LE(worst(arguments<T>(low, high), L::exp, exp), 1.0L);
    EXPECT_LE(worst(arguments<T>(-1, 1), L::exp, exp), 1.0L);
    const auto gauss = [](Wide x) { return std::exp(-x * x); };
    const T end = TestFixture::kDouble ? T(26.6) : T(9.3);
    EXPECT_LE(worst(arguments<T>(-end, end), L::gauss, gauss), 1.0L);
    EXPECT_EQ(L::exp(T(0)), T(1));
    EXPECT_EQ(L::gauss(T(0)), T(1));
}

// hi + lo is rounded once where e ≠ 0. At e = 0 it is that rounding, too: 0.5 and a trifle.
TYPED_TEST(LaneMath, Logarithms) {
    using T = TypeParam;
    using L = Lane<T>;
    const auto right = [](Wide x) { return std::log2(x); };
    for (const T top : {T(1), T(2), T(100), TestFixture::kHuge})
        EXPECT_LE(worst(arguments<T>(TestFixture::kTiny, top), L::log2, right), 0.75L) << top;
    EXPECT_LE(worst(arguments<T>(T(0.99), T(1.01)), L::log2, right), 0.75L);
    std::vector<T> scales;
    for (const T x : arguments<T>(4 - TestFixture::kExponents, TestFixture::kExponents - 1))
        scales.push_back(std::exp2(x));
    EXPECT_LE(worst(scales, L::log2, right), 0.75L);
    for (int n = 3 - int(TestFixture::kExponents); n < int(TestFixture::kExponents); ++n)
        EXPECT_EQ(L::log2(std::ldexp(T(1), n)), T(n));
    EXPECT_EQ(L::log2(T(0)), -TestFixture::kHuge);
}

// 1 ulp as of powers of two, and four roundings of the logarithm's s³ term, which is at most 1 % of
// it: times |y log2 x| ln 2 ≤ 87 (707) that is 1.7 ulp (14 ulp) at the very ends.
TYPED_TEST(LaneMath, Powers) {
    using T = TypeParam;
    using L = Lane<T>;
    std::mt19937_64 random(11);
    const T ends = TestFixture::kExponents - 3;
    std::uniform_real_distribution<T> logarithm(-20, 20), exponent(-ends, ends), unit(0, 1);
    Wide in_the_middle = 0, at_the_ends = 0, of_sines = 0;
    for (int i = 0; i < 400000; ++i) {
        const T x = std::exp2(logarithm(random)), e = exponent(random);
        const T y = e / std::log2(x);
        const T near = 1 + (x - 1) / (1 + std::abs(x)) / 1000;  // 1 ± 1e-3
        at_the_ends = std::max(at_the_ends, ulps(L::pow(x, y), std::pow(Wide(x), Wide(y))));
        const T y_near = near == 1 ? T(1) : e / std::log2(near);
        at_the_ends =
            std::max(at_the_ends, ulps(L::pow(near, y_near), std::pow(Wide(near), Wide(y_near))));
        in_the_middle =
            std::max(in_the_middle, ulps(L::pow(x, y / 64), std::pow(Wide(x), Wide(y / 64))));
        // sin^(1/α) of Charlie's distribution
        const T sine = unit(random), inverse = 1 + 100 * unit(random);
        const Wide power = std::pow(Wide(sine), Wide(inverse));
        if (power > 8 * Wide(TestFixture::kTiny))
            of_sines = std::max(of_sines, ulps(L::pow(sine, inverse), power));
    }
    EXPECT_LE(at_the_ends, TestFixture::kDouble ? 15.0L : 2.7L);
    EXPECT_LE(in_the_middle, 1.3L);
    EXPECT_LE(of_sines, 2.0L);
}

TYPED_TEST(LaneMath, PowersOfZeroAndOne) {
    using T = TypeParam;
    using L = Lane<T>;
    for (const T y : {T(1e-20), T(0.5), T(1), T(1000), T(1e30)}) {
        EXPECT_EQ(L::pow(0, y), T(0)) << y;
        EXPECT_EQ(L::pow(0, -y), TestFixture::kInfinity) << y;
        EXPECT_EQ(L::pow(1, y), T(1)) << y;
        EXPECT_EQ(L::pow(y, 0), T(1)) << y;
        EXPECT_LE(ulps(L::pow(y, 1), y), 1.0L) << y;
    }
    EXPECT_EQ(L::pow(0, 0), T(1));
}

// (1 − x)^y where 1 − x itself keeps no digit of x: Charlie's power near the horizon, Schlick's at
// grazing. What 1 - x has lost is known to three roundings, of which |y ln(1 - x)| makes as many
// units of the last place as it counts.
TYPED_TEST(LaneMath, PowersOfOneMinus) {
    using T = TypeParam;
    using L = Lane<T>;
    std::mt19937_64 random(12);
    std::uniform_real_distribution<T> decades(-14, 0), size(0, 60);
    Wide most = 0;
    for (int i = 0; i < 200000; ++i) {
        const T x = std::pow(T(10), decades(random)) * T(0.99);
        const T y = size(random) / -std::log1p(-x);
        const Wide logarithm = Wide(y) * std::log1p(-Wide(x));
        most = std::max(most, ulps(L::pow_one_minus(x, y), std::exp(logarithm)) / (1 - logarithm));
    }
    EXPECT_LE(most, 3.0L);
    EXPECT_EQ(L::pow_one_minus(1, T(5)), T(0));
    EXPECT_EQ(L::pow_one_minus(0, T(1000)), T(1));
}

/// 1 − √π a erfcx(a) = ∫₀^∞ 2 t exp(−t² − 2 a t) dt by the trapezoidal rule in ln t, whose error at
/// this step is below 1e-30.
Wide erfcx_deficit(Wide a) {
    constexpr int kPerUnit = 16;
    Wide sum = 0;
    for (int i = -26 * kPerUnit; i <= 3 * kPerUnit; ++i) {
        const Wide t = std::exp(Wide(i) / kPerUnit);
        sum += 2 * t * t * std::exp(-t * (t + 2 * a));
    }
    return sum / kPerUnit;
}

// y carries two roundings and the polynomial's slope in it is below 0.3; the polynomial, the
// divisor (three roundings) and the quotient: 4 ulp at most.
TYPED_TEST(LaneMath, ErfcxDeficit) {
    using T = TypeParam;
    using L = Lane<T>;
    const T end = TestFixture::kDouble ? 27 : 10;
    std::vector<T> few = {0, TestFixture::kTiny, T(1e-10), T(1e-3), end};
    for (int i = 0; i < 3000; ++i) few.push_back(end * T(i) * T(i) / 9000000);
    EXPECT_LE(worst(few, L::erfcx_deficit, erfcx_deficit), 4.0L);
    EXPECT_EQ(L::erfcx_deficit(0), T(1));
    EXPECT_EQ(L::erfcx_deficit(TestFixture::kInfinity), L::erfcx_deficit(end));
    // Beckmann's Λ by the formula of erf, where that formula still has digits.
    for (const T a : {T(0.01), T(0.3), T(1), T(1.5)}) {
        const Wide pi = std::numbers::pi_v<Wide>, w = a;
        const Wide textbook = (std::erf(w) - 1) / 2 + std::exp(-w * w) / (2 * w * std::sqrt(pi));
        const T ours = L::gauss(a) * L::erfcx_deficit(a) / T(2 * w * std::sqrt(pi));
        EXPECT_LE(ulps(ours, textbook), 6.0L) << a;
    }
}

// asin of up to 1/2 or of √z, z exact: half an ulp each for √, its polynomial and the last sum.
TYPED_TEST(LaneMath, ArcCosines) {
    using T = TypeParam;
    using L = Lane<T>;
    const auto right = [](Wide x) { return std::acos(x); };
    EXPECT_LE(worst(arguments<T>(-1, 1), L::acos, right), 2.0L);
    EXPECT_LE(worst(arguments<T>(T(0.999), 1), L::acos, right), 2.0L);
    EXPECT_LE(worst(arguments<T>(T(-0.001), T(0.001)), L::acos, right), 1.0L);
    const auto sine = [](Wide x) { return std::asin(x); };
    // just above 1/2, twice the arc is π/3 and its last place counts two of the result's
    EXPECT_LE(worst(arguments<T>(0, 1), L::asin, sine), 3.0L);
    EXPECT_LE(worst(arguments<T>(0, T(0.001)), L::asin, sine), 1.0L);
    EXPECT_EQ(L::asin(1), std::numbers::pi_v<T> / 2);
    EXPECT_EQ(L::acos(1), T(0));
    EXPECT_EQ(L::acos(0), std::numbers::pi_v<T> / 2);
    EXPECT_EQ(L::acos(-1), std::numbers::pi_v<T>);
}

TYPED_TEST(LaneMath, ChoicesPassANumberOnUnchangedAndANaNInTheFirstPlace) {
    using T = TypeParam;
    using L = Lane<T>;
    EXPECT_EQ(L::min(2, 3), T(2));
    EXPECT_EQ(L::min(3, 2), T(2));
    EXPECT_EQ(L::max(2, 3), T(3));
    EXPECT_EQ(L::max(3, 2), T(3));
    EXPECT_TRUE(std::isnan(L::min(TestFixture::kNaN, 2)));
    EXPECT_TRUE(std::isnan(L::max(TestFixture::kNaN, 2)));
    EXPECT_EQ(L::abs(T(-2.5)), T(2.5));
    EXPECT_EQ(L::abs(T(2.5)), T(2.5));
    EXPECT_EQ(L::saturate(T(-0.1)), T(0));
    EXPECT_EQ(L::saturate(T(0.3)), T(0.3));
    EXPECT_EQ(L::saturate(T(1.1)), T(1));
}

}  // namespace
