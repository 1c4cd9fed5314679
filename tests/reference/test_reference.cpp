// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>

#include "tests/reference/reference.h"

// Spot values, anchors and agreement of methods. Where no other tolerance is derived, 1e-12 holds:
// the stated accuracy of the library, and wider than the last digit of the values given.
namespace kiln::reference {
namespace {

constexpr double kExact = 1e-12;
constexpr Masking kBoth[] = {Masking::correlated, Masking::separable};
constexpr double kMu[] = {1e-4, 1e-3, .01, .1, .3, .5, .8, 1};
constexpr double kAlpha[] = {1e-4, 1e-3, .01, .05, .1, .25, .5, .8, 1};

struct Spot {
    double mu, alpha, correlated, separable;
};

// Single-scattering GGX albedo, computed outside this library by two independent integrators.
constexpr Spot kSpots[] = {
    {.01, .01, 0.891987352354539, 0.8815273213614876},
    {.1, .01, 0.9941239527697188, 0.9941162704505172},
    {.5, .01, 0.9997421225991306, 0.9997421165745943},
    {1, .01, 0.9998985564060227, 0.9998985564060227},
    {.01, .1, 0.9765382638655168, 0.9196002966549326},
    {.1, .1, 0.8834550018671463, 0.872756083634446},
    {.5, .1, 0.9692049844116893, 0.9691151156162618},
    {1, .1, 0.988304056520612, 0.988304056520612},
    {.01, .25, 0.9819696119683294, 0.8936422439222236},
    {.1, .25, 0.8916223518094879, 0.8542963764175526},
    {.5, .25, 0.8572634355815696, 0.855098534363639},
    {1, .25, 0.9158124302497503, 0.9158124302497503},
    {.01, 1, 0.9538487948315874, 0.6076293454258509},
    {.1, 1, 0.760210472720163, 0.5579142171637358},
    {.5, 1, 0.45069385566594516, 0.4091370925867396},
    {1, 1, 0.3068528194400547, 0.3068528194400547},
};

TEST(Reference, DirectionalAlbedoHasTheSpotValues) {
    for (const Spot& spot : kSpots) {
        SCOPED_TRACE(testing::Message() << "mu " << spot.mu << " alpha " << spot.alpha);
        EXPECT_NEAR(directional_albedo(spot.mu, spot.alpha, Masking::correlated), spot.correlated,
                    kExact);
        EXPECT_NEAR(directional_albedo(spot.mu, spot.alpha, Masking::separable), spot.separable,
                    kExact);
    }
}

TEST(Reference, SplitSumHasTheSpotValues) {
    const struct {
        double mu, alpha, scale, bias;
    } spots[] = {
        {.1, .25, 0.7519299007930861, 0.13969245101640185},
        {.5, .1, 0.9370659288149166, 0.03213905559677277},
        {1, .25, 0.9157850593233247, 2.7370926425609045e-05},
        {.01, 1, 0.911068933200578, 0.04277986163100939},
    };
    for (const auto& spot : spots) {
        const SplitSum sum = split_sum(spot.mu, spot.alpha, Masking::correlated);
        EXPECT_NEAR(sum.scale, spot.scale, kExact) << spot.mu << ' ' << spot.alpha;
        EXPECT_NEAR(sum.bias, spot.bias, kExact) << spot.mu << ' ' << spot.alpha;
    }
}

TEST(Reference, AveragesAndMultiscatterHaveTheSpotValues) {
    const struct {
        double alpha, correlated, separable;
    } spots[] = {
        {.01, 0.9994905456798838, 0.9994854716008583},
        {.1, 0.9720457568157044, 0.9715594830553832},
        {.25, 0.8823233826182513, 0.8794556695204585},
        {1, 0.4091370925867399, 0.37663461119324343},
    };
    for (const auto& spot : spots) {
        EXPECT_NEAR(average_albedo(spot.alpha, Masking::correlated), spot.correlated, kExact);
        EXPECT_NEAR(average_albedo(spot.alpha, Masking::separable), spot.separable, kExact);
        // Relative 1e-8 as stated; the value subtracted from 1 is good to 1e-15 of at least 5e-4.
        EXPECT_NEAR(average_deficit(spot.alpha, Masking::correlated) / (1 - spot.correlated), 1,
                    1e-8);
        EXPECT_NEAR(average_deficit(spot.alpha, Masking::separable) / (1 - spot.separable), 1,
                    1e-8);
    }
    // Kulla-Conty's lobe at mu_o = mu_i = .5.
    const double d = deficit(.5, .25, Masking::correlated);
    EXPECT_NEAR(d * d / (std::numbers::pi * average_deficit(.25, Masking::correlated)),
                0.05511000239584466, 1e-9);  // two relative errors of 1e-9, one of 1e-8, times .055
}

TEST(Reference, SplitSumHasThePublishedAnchors) {
    // A and B of the correlated lobe by roughness .25, .5, .75, 1; seven digits, so half a unit is
    // 5e-8.
    const double mu[] = {.1, .25, .5, .75, 1};
    const double anchors[5][4][2] = {
        {{.5051473, .3916224}, {.7519299, .1396925}, {.7957729, .0525829}, {.7363436, .0238669}},
        {{.7580312, .2035357}, {.7592544, .0808275}, {.7165080, .0279483}, {.5867643, .0108763}},
        {{.9556867, .0326373}, {.8349161, .0223473}, {.6546928, .0084830}, {.4477051, .0029887}},
        {{.9923089, .0015022}, {.8888142, .0027187}, {.6312440, .0016414}, {.3638935, .0006331}},
        {{.9956851, .0000030}, {.9157851, .0000274}, {.6268380, .0000476}, {.3068192, .0000336}}};
    const double average[2][4] = {{.9872503, .8823234, .6562014, .4091371},
                                  {.9870566, .8794557, .6427544, .3766346}};
    for (int column = 0; column < 4; ++column) {
        const double roughness = .25 * (column + 1), alpha = roughness * roughness;
        for (int row = 0; row < 5; ++row) {
            const SplitSum sum = split_sum(mu[row], alpha, Masking::correlated);
            EXPECT_NEAR(sum.scale, anchors[row][column][0], 5.1e-8) << mu[row] << ' ' << roughness;
            EXPECT_NEAR(sum.bias, anchors[row][column][1], 5.1e-8) << mu[row] << ' ' << roughness;
        }
        EXPECT_NEAR(average_albedo(alpha, Masking::correlated), average[0][column], 5.1e-8);
        EXPECT_NEAR(average_albedo(alpha, Masking::separable), average[1][column], 5.1e-8);
    }
    const struct {
        double mu, roughness, albedo, bias;
    } separable[] = {{.1, .25, .892473, .389015},
                     {.25, .5, .828512, .078369},
                     {.5, .75, .647443, .007974},
                     {.5, 1, .409137, .002456}};
    for (const auto& a : separable) {
        const SplitSum sum = split_sum(a.mu, a.roughness * a.roughness, Masking::separable);
        EXPECT_NEAR(sum.scale + sum.bias, a.albedo, 5.1e-7);
        EXPECT_NEAR(sum.bias, a.bias, 5.1e-7);
    }
}

// Elevation of the reflected direction with a closed azimuth, half-vectors with a numerical one,
// and the missing part counted alone share no variable. Each is stated at 1e-12 or better, so they
// may differ by twice that; seen: 3e-15 and 5e-15.
TEST(Reference, ThreeIntegralsOfTheAlbedoAgree) {
    for (const Masking masking : kBoth)
        for (const double mu : kMu)
            for (const double alpha : kAlpha) {
                SCOPED_TRACE(testing::Message() << "mu " << mu << " alpha " << alpha);
                const double albedo = directional_albedo(mu, alpha, masking);
                const double missing = deficit(mu, alpha, masking);
                EXPECT_NEAR(albedo, directional_albedo_half_vector(mu, alpha, masking), 2e-12);
                EXPECT_NEAR(albedo + missing, 1, 2e-12);
                // 1 - E as a difference carries the rounding of E: 1e-14 of a deficit of 1e-8 and
                // more.
                EXPECT_NEAR((1 - albedo) / missing, 1, 1e-9 + 1e-14 / missing);
            }
}

TEST(Reference, ScaleAndBiasSumToTheAlbedo) {
    for (const Masking masking : kBoth)
        for (const double mu : {0., 1e-4, 1e-3, .01, .1, .3, .5, .8, 1.})
            for (const double alpha : kAlpha) {
                const SplitSum sum = split_sum(mu, alpha, masking);
                EXPECT_NEAR(sum.scale + sum.bias, directional_albedo(mu, alpha, masking), kExact)
                    << "mu " << mu << " alpha " << alpha;
                EXPECT_GE(sum.bias, 0);
                EXPECT_GE(sum.scale, 0);
            }
}

TEST(Reference, AlbedoUnderAnyFresnel) {
    const auto schlick = [](double u) { return .04 + .96 * std::pow(1 - u, 5); };
    // Unpolarised reflectance at a complex index, textbook spelling (Born and Wolf, section 1.5).
    const auto fresnel = [](double u, std::complex<double> index) {
        const auto transmitted = std::sqrt(1.0 - (1 - u * u) / (index * index));
        const auto s = (u - index * transmitted) / (u + index * transmitted);
        const auto p = (index * u - transmitted) / (index * u + transmitted);
        return (std::norm(s) + std::norm(p)) / 2;
    };
    const struct {
        double mu, alpha, dielectric, conductor;
    } spots[] = {
        {.1, .01, 0.5606928591947141, 0.9583963854881774},
        {.5, .25, 0.06689850709319349, 0.8063285627056721},
        {.1, .25, 0.1718396987451538, 0.8404943404865305},
        {1, 1, 0.012702412787269034, 0.2896979825587221},
    };
    for (const auto& spot : spots) {
        const auto albedo = [&](std::complex<double> index) {
            return albedo_with_fresnel(spot.mu, spot.alpha, Masking::correlated,
                                       [&](double u) { return fresnel(u, index); });
        };
        EXPECT_NEAR(albedo(1.5), spot.dielectric, kExact) << spot.mu << ' ' << spot.alpha;
        EXPECT_NEAR(albedo({.18, 3.4}), spot.conductor, kExact) << spot.mu << ' ' << spot.alpha;
        const SplitSum sum = split_sum(spot.mu, spot.alpha, Masking::separable);
        EXPECT_NEAR(albedo_with_fresnel(spot.mu, spot.alpha, Masking::separable, schlick),
                    .04 * sum.scale + sum.bias, kExact);
    }
}

TEST(Reference, TablesAreTheScalarsInRowOrder) {
    const double mu[] = {0, 1e-3, .05, .4, 1};
    const double alpha[] = {0, 1e-4, .01, .2, .7};
    for (const Masking masking : kBoth) {
        const auto pairs = split_sum_table(masking, mu, alpha);
        const auto scale = table(Quantity::scale, masking, mu, alpha, 1);
        const auto bias = table(Quantity::bias, masking, mu, alpha, 3);
        const auto albedo = table(Quantity::directional, masking, mu, alpha);
        const auto average = table(Quantity::average, masking, mu, alpha);
        const auto missing = table(Quantity::multiscatter, masking, mu, alpha);
        for (std::size_t i = 0; i < 25; ++i) {
            SCOPED_TRACE(testing::Message() << "mu " << mu[i % 5] << " alpha " << alpha[i / 5]);
            const SplitSum sum = split_sum(mu[i % 5], alpha[i / 5], masking);
            const double exact = deficit(mu[i % 5], alpha[i / 5], masking);
            // The stated accuracies of tables: absolute 1e-9, deficit relative 1e-6.
            EXPECT_NEAR(pairs[i].scale, sum.scale, 1e-9);
            EXPECT_NEAR(pairs[i].bias, sum.bias, 1e-9);
            EXPECT_EQ(scale[i], pairs[i].scale);
            EXPECT_EQ(bias[i], pairs[i].bias);
            EXPECT_NEAR(albedo[i], directional_albedo(mu[i % 5], alpha[i / 5], masking), 1e-9);
            EXPECT_EQ(average[i], average_albedo(alpha[i / 5], masking));
            EXPECT_NEAR(missing[i], exact, 1e-6 * exact);
        }
    }
}

TEST(Reference, RefusesWhatItCannotAnswer) {
    for (const double bad : {-.1, 1.0000001, 1e-10, std::nan("")}) {
        EXPECT_THROW(directional_albedo(bad, .5, Masking::correlated), std::domain_error) << bad;
        EXPECT_THROW(deficit(.5, bad, Masking::correlated), std::domain_error) << bad;
        EXPECT_THROW(split_sum(bad, .5, Masking::separable), std::domain_error) << bad;
        EXPECT_THROW(average_albedo(bad, Masking::separable), std::domain_error) << bad;
        const double rows[] = {.5, bad};
        EXPECT_THROW(table(Quantity::bias, Masking::correlated, rows, rows), std::domain_error);
    }
    EXPECT_THROW(albedo_with_fresnel(.5, .5, Masking::correlated, [](double) { return NAN; }),
                 std::domain_error);
}

}  // namespace
}  // namespace kiln::reference
