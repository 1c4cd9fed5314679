// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>
#include <type_traits>

#include "server/compute/fresnel.h"
#include "tests/kernels/one_lane.h"
#include "tests/kernels/textbook_fresnel.h"

namespace {

using kiln::Fresnel;
using kiln::FresnelModel;

template <class T>
T evaluate(const FresnelModel& model, T VoH) {
    const auto parameters = kiln::fresnel_parameters(model, 0);
    std::array<T, KILN_FRESNEL_PARAMETERS> p{};
    std::transform(parameters.begin(), parameters.end(), p.begin(),
                   [](double value) { return static_cast<T>(value); });
    const int function = kiln::fresnel_function(model);
    if constexpr (std::is_same_v<T, double>)
        return in_double::fresnel(function, p.data(), VoH);
    else
        return in_float::fresnel(function, p.data(), VoH);
}

FresnelModel dielectric(double ior) {
    FresnelModel model{.model = Fresnel::dielectric};
    model.ior = {ior};
    return model;
}

FresnelModel conductor(double eta, double k) {
    FresnelModel model{.model = Fresnel::conductor};
    model.eta = {eta};
    model.k = {k};
    return model;
}

FresnelModel schlick(double f0, double f90, double exponent) {
    FresnelModel model{.model = Fresnel::schlick, .exponent = exponent};
    model.f0 = {f0};
    model.f90 = {f90};
    return model;
}

FresnelModel f82_tint(double f0, double f82) {
    FresnelModel model{.model = Fresnel::f82_tint};
    model.f0 = {f0};
    model.f82 = {f82};
    return model;
}

const double kCosines[] = {1e-9, 1e-4, 1e-3, 0.01,  0.1,      0.3, 0.5,
                           0.7,  0.8,  0.95, 0.999, 1 - 1e-7, 1};

/// Largest relative error of the kernel in T over kCosines, against the textbook at the same
/// cosine.
template <class T>
double error(const FresnelModel& model, std::complex<textbook::Extended> index) {
    double worst = 0;
    for (const double cosine : kCosines) {
        const T VoH = static_cast<T>(cosine);
        const auto exact = textbook::fresnel(index, VoH);
        const auto off =
            std::abs((static_cast<textbook::Extended>(evaluate<T>(model, VoH)) - exact) / exact);
        if (!(off <= worst)) worst = static_cast<double>(off);
    }
    return worst;
}

// Both exact models take 25 roundings or fewer, each counted twice at most (a square): 50 × 2^-53
// = 5.6e-15 and 50 × 2^-24 = 3.0e-6 bound the relative error where no subtraction cancels. That is
// so but for the rim of total reflection.
constexpr double kInDouble = 5.6e-15, kInFloat = 3.0e-6;

/// What the textbook's differences lose near an index of 1: some 8 roundings of 5.4e-20.
double textbook_error(std::complex<double> index) { return 4e-19 / std::abs(index - 1.0); }

}  // namespace

TEST(Schlick, WeighsTheFifthPower) {
    for (const double VoH : {0.0, 0.1, 0.5, 0.9, 1.0})
        // Four multiplications of relative rounding 1.1e-16.
        EXPECT_NEAR(in_double::fresnel_schlick_weight(VoH), std::pow(1 - VoH, 5), 5e-16) << VoH;
}

TEST(Schlick, ACosineThatRoundingPutAboveOneWeighsNothing) {
    EXPECT_EQ(in_float::fresnel_schlick_weight(1.0000001f), 0.0f);
    EXPECT_EQ(in_double::fresnel_schlick_weight(1.0 + 1e-9), 0.0);
    for (const double exponent : {0.5, 4.0, 5.0})
        EXPECT_EQ(evaluate(schlick(0.25, 1, exponent), 1.0000001f), 0.25f) << exponent;
}

TEST(Schlick, MixesF0AndF90WithAnyExponent) {
    for (const double exponent : {0.01, 0.5, 1.0, 3.0, 5.0, 7.25, 1000.0})
        for (const double VoH : {0.0, 0.1, 0.5, 0.9, 1.0}) {
            const double exact = 0.9 + (0.2 - 0.9) * std::pow(1 - VoH, exponent);
            EXPECT_NEAR(evaluate(schlick(0.9, 0.2, exponent), VoH), exact, 1e-15);
            // 1 − VoH is off by 2^-24 relative, which the power multiplies: x^n n 2^-24 ≤ 2^-24 for
            // what remains of x^n; and three roundings of values ≤ 1.
            const double at_float = 0.9 + (0.2 - 0.9) * std::pow(1 - double(float(VoH)), exponent);
            EXPECT_NEAR(evaluate(schlick(0.9, 0.2, exponent), float(VoH)), at_float, 3e-7);
        }
}

TEST(FresnelNone, IsOne) {
    FresnelModel model{.model = Fresnel::none};
    EXPECT_EQ(evaluate(model, 0.3), 1.0);
    EXPECT_EQ(evaluate(model, 0.3f), 1.0f);
}

TEST(Dielectric, AgreesWithTheTextbook) {
    for (const double ior : {1 + 1e-7, 1.001, 1.33, 1.5, 2.4, 10.0, 1e3, 1e6}) {
        EXPECT_LT(error<double>(dielectric(ior), ior), kInDouble + textbook_error(ior)) << ior;
        EXPECT_LT(error<float>(dielectric(ior), ior), kInFloat) << ior;
    }
    // Inside the denser medium. Where a cosine comes nearest to a rim (0.7 to 0.66), η² − s² is a
    // tenth of its terms and adds ten roundings.
    for (const double ior : {1e-4, 0.01, 0.3, 1 / 2.4, 1 / 1.5, 1 / 1.33, 1 - 1e-7}) {
        EXPECT_LT(error<double>(dielectric(ior), ior), 2 * kInDouble + textbook_error(ior)) << ior;
        EXPECT_LT(error<float>(dielectric(ior), ior), 2 * kInFloat) << ior;
    }
}

TEST(Dielectric, HasItsLimits) {
    EXPECT_NEAR(evaluate(dielectric(1.5), 1.0), 0.04, 1e-17);
    EXPECT_NEAR(evaluate(dielectric(1 + 1e-7), 1.0), 2.5e-15, 1e-21);
    EXPECT_NEAR(evaluate(dielectric(1 + 1e-7), 1e-3f), 2.0747e-3, 1e-7);
    EXPECT_NEAR(evaluate(dielectric(10), 1.0), 0.669421, 5e-7);
    EXPECT_NEAR(evaluate(dielectric(1e3), 1.0), 0.996008, 5e-7);
    EXPECT_NEAR(evaluate(dielectric(1e6), 1.0f), 0.999996, 5e-7);
    EXPECT_NEAR(evaluate(dielectric(1e3), 1e-3f), 0.499998, 1e-6);
    EXPECT_NEAR(evaluate(dielectric(1.5), 0.0), 1.0, kInDouble);
    for (const float VoH : {0.0f, 1e-30f, 0.5f, 1.0f})
        EXPECT_EQ(evaluate(dielectric(1), VoH), 0.0f);
}

TEST(Dielectric, ReflectsAllBeyondTheCriticalAngle) {
    const double rim = std::sqrt(5.0) / 3;  // √(1 − (1/1.5)²)
    EXPECT_EQ(evaluate(dielectric(1 / 1.5), rim - 1e-9), 1.0);
    EXPECT_LT(evaluate(dielectric(1 / 1.5), rim + 1e-9), 1.0);
    EXPECT_EQ(evaluate(dielectric(1 / 1.5), 0.7453f), 1.0f);
    EXPECT_LT(evaluate(dielectric(1 / 1.5), 0.7454f), 1.0f);
    EXPECT_NEAR(evaluate(dielectric(1 / 1.5), 1.0f), 0.04f, 1e-8);
}

TEST(Conductor, AgreesWithTheTextbook) {
    const double pairs[][2] = {{1e-4, 5},   {0.18, 3.4},  {1.5, 7.6},   {0.05, 2},
                               {1, 1e-6},   {1, 1e-3},    {1e5, 1e5},   {1e6, 1e6},
                               {0, 3},      {0, 1},       {1e-4, 1e-4}, {0.3, 0.2},
                               {1.5, 0},    {3.2, 3.3},   {1e-4, 1e6},  {1e6, 0},
                               {0.6, 1e-3}, {1e-4, 1e-3}, {0.01, 0.01}, {0.7072, 1e-3}};
    for (const auto& [eta, k] : pairs) {
        EXPECT_LT(error<double>(conductor(eta, k), {eta, k}), kInDouble + textbook_error({eta, k}))
            << eta << " + i " << k;
        EXPECT_LT(error<float>(conductor(eta, k), {eta, k}), kInFloat) << eta << " + i " << k;
    }
}

TEST(Conductor, HasItsLimits) {
    EXPECT_NEAR(evaluate(conductor(1e-4, 5), 1.0), 0.99998462, 5e-9);
    EXPECT_NEAR(evaluate(conductor(1e-4, 5), 0.5), 0.99998186, 5e-9);
    EXPECT_NEAR(evaluate(conductor(1, 1e-6), 1e-3f), 0.119726, 5e-7);
    EXPECT_NEAR(evaluate(conductor(1, 1e-6), 1.0f), 0.0, 1e-12);
    EXPECT_NEAR(evaluate(conductor(1e5, 1e5), 1.0f), 0.99998, 1e-6);
    EXPECT_NEAR(evaluate(conductor(1e5, 1e5), 1e-3f), 0.99009949, 1e-6);
    for (const float VoH : {0.0f, 0.5f, 1.0f}) EXPECT_EQ(evaluate(conductor(1, 0), VoH), 0.0f);
    // Without absorption and on the rim of total reflection √(ε − s²) is 0: η² = s² = 3/4.
    EXPECT_NEAR(evaluate(conductor(std::sqrt(0.75), 0), 0.5f), 1.0f, kInFloat);
}

TEST(Conductor, WithoutAbsorptionIsTheDielectric) {
    for (const double ior : {0.4, 1 / 1.5, 1.33, 2.4})
        for (const double cosine : kCosines)
            // Both are within kInDouble of the exact value, and 60 times that near total
            // reflection.
            EXPECT_NEAR(evaluate(conductor(ior, 0), cosine), evaluate(dielectric(ior), cosine),
                        61 * kInDouble);
}

TEST(F82Tint, TintsSchlickAtOneSeventh) {
    const double at = 1.0 / 7;
    for (const double f82 : {0.0, 0.5, 0.9, 1.0}) {
        const double plain = evaluate(schlick(0.7, 1, 5), at);
        EXPECT_NEAR(evaluate(f82_tint(0.7, f82), at), f82 * plain, 1e-15);
        EXPECT_NEAR(evaluate(f82_tint(0.7, f82), float(at)), f82 * plain, 3e-7);
        EXPECT_EQ(evaluate(f82_tint(0.7, f82), 1.0), 0.7);
        EXPECT_EQ(evaluate(f82_tint(0.7, f82), 0.0), 1.0);
    }
    for (const double VoH : {0.05, 0.4, 0.8})  // and elsewhere takes away b μ (1 − μ)^6
        EXPECT_NEAR(evaluate(f82_tint(0.7, 0.5), VoH),
                    evaluate(schlick(0.7, 1, 5), VoH) - evaluate(schlick(0.7, 1, 5), at) * 0.5 *
                                                            (VoH * std::pow(1 - VoH, 6)) /
                                                            (at * std::pow(6.0 / 7, 6)),
                    1e-15);
}

// Every parameter that the host lets through, at its ends and between them, at cosines from 0 to
// what rounding makes of 1: no NaN, and nothing beyond [0, 1] but by rounding.
template <class T>
void sweep(double slack) {
    std::mt19937_64 random(7);
    std::uniform_real_distribution<double> uniform(0, 1);
    const auto fraction = [&] {
        const double u = uniform(random);
        return u < 0.15 ? 0 : u > 0.85 ? 1 : uniform(random);
    };
    const auto index = [&] { return std::pow(10.0, -4 + 10 * fraction()); };
    for (int i = 0; i < 20000; ++i) {
        const double small = fraction() < 0.5 ? 0 : index(), f0 = fraction();
        FresnelModel tint{.model = Fresnel::edge_tint};
        tint.reflectivity = {0.99999 * fraction()};
        tint.edge_tint = {fraction()};
        const double least = kiln::f82_least(f0);
        const FresnelModel models[] = {dielectric(index()),
                                       conductor(index(), small),
                                       conductor(small, index()),
                                       schlick(f0, fraction(), index() * 1e-3),
                                       schlick(f0, fraction(), 5),
                                       tint,
                                       f82_tint(f0, least + (1 - least) * fraction())};
        const T cosines[] = {T(fraction()), T(std::pow(10, -30 * fraction())),
                             T(1 + 1e-6 * fraction())};
        for (const FresnelModel& model : models)
            for (const T VoH : cosines) {
                const T F = evaluate<T>(model, VoH);
                ASSERT_TRUE(F >= -slack && F <= 1 + slack)
                    << F << " from model " << static_cast<int>(model.model) << " at " << VoH;
            }
    }
}

TEST(Fresnel, StaysWithinZeroAndOneInFloat) { sweep<float>(kInFloat); }
TEST(Fresnel, StaysWithinZeroAndOneInDouble) { sweep<double>(kInDouble); }
