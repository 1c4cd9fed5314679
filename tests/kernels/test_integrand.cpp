// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "server/compute/points.h"
#include "tests/kernels/one_lane.h"
#include "tests/kernels/textbook.h"

namespace {

constexpr in_double::Integrand kAll = {KILN_MASKING_SMITH_CORRELATED, KILN_IMPORTANCE_VNDF, 7};

in_double::Terms terms_at(const in_double::Integrand& what, double NoV, double alpha, double u,
                          double phi) {
    const in_double::View view = in_double::ggx_view(NoV, alpha);
    const double rest = 1 - u, z = std::sqrt(rest);
    const double of_all[] = {std::sqrt(u) * std::cos(phi), z, 1 / z, rest};
    const auto visible = kiln::visible_normal_point(std::cos(phi), u);
    const bool all = what.importance == KILN_IMPORTANCE_NDF;
    const double* point = all ? of_all : visible.data();
    const auto h =
        all ? in_double::ggx_sample_ndf(view, point) : in_double::ggx_sample_vndf(view, point);
    const double NoH = in_double::half_vector_NoH(what.importance, point);
    return in_double::weigh(what, view, h, in_double::ggx_mirror(view, h, NoH),
                            in_double::ggx_one_minus_VoH(view, h), point[2]);
}

}  // namespace

// f NoL / pdf of a half vector drawn from D, by the published product: D G2 / (4 NoV NoL) · NoL /
// (D NoH / 4 VoH).
TEST(Integrand, IsBrdfTimesCosineOverDensity) {
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> uniform(0.01, 0.99);
    const in_double::Integrand ndf = {KILN_MASKING_SMITH_CORRELATED, KILN_IMPORTANCE_NDF, 7};
    for (int i = 0; i < 20000; ++i) {
        const double NoV = uniform(random), alpha = uniform(random), u = uniform(random),
                     phi = 3.14 * uniform(random);
        const double t = alpha * std::sqrt(u / (1 - u)), z = 1 / std::sqrt(1 + t * t);
        const textbook::Vector h = {t * z * std::cos(phi), t * z * std::sin(phi), z};
        const double VoH = textbook::dot(textbook::view(NoV), h), NoL = 2 * VoH * z - NoV;
        const double brdf = NoL > 0 ? textbook::D(h, alpha) *
                                          textbook::G2_correlated(NoV, NoL, alpha) / (4 * NoV * NoL)
                                    : 0;
        const double wanted = NoL > 0 ? brdf * NoL * 4 * VoH / textbook::all_normals(h, alpha) : 0;
        const in_double::Terms terms = terms_at(ndf, NoV, alpha, u, phi);
        // A light near the horizon makes NoL a difference: 1e-16 / NoL of relative rounding, with
        // 1e-5 < NoL.
        EXPECT_NEAR(terms.weight, wanted, 1e-10 * (1 + wanted));
        EXPECT_NEAR(terms.fresnel, wanted * std::pow(1 - std::min(VoH, 1.0), 5),
                    1e-10 * (1 + wanted));
    }
}

TEST(Integrand, WeightAndDeficitAddUpToOne) {
    std::mt19937_64 random(4);
    std::uniform_real_distribution<double> uniform(0.001, 0.999);
    for (int i = 0; i < 20000; ++i) {
        const auto terms = terms_at(kAll, uniform(random), uniform(random), uniform(random),
                                    3.14 * uniform(random));
        EXPECT_NEAR(terms.weight + terms.deficit, 1, 1e-14);
        EXPECT_GE(terms.weight, 0);
        EXPECT_LE(terms.weight, 1 + 1e-15);  // G2 ≤ G1(V)
        EXPECT_GE(terms.fresnel, 0);
    }
}

TEST(Integrand, LimitsAreValuesAndNotNaN) {
    for (const double u : {1e-9, 0.3, 1 - 1e-9}) {
        for (const double phi : {0.0, 1.0, 3.14159}) {
            const auto mirror = terms_at(kAll, 0.4, 0, u, phi);
            EXPECT_NEAR(mirror.weight, 1, 1e-15);
            EXPECT_NEAR(mirror.fresnel, std::pow(0.6, 5), 1e-15);
            EXPECT_NEAR(mirror.deficit, 0, 1e-15);
            const auto grazing_mirror = terms_at(kAll, 0, 0, u, phi);
            EXPECT_NEAR(grazing_mirror.weight, 1, 1e-15);
            EXPECT_NEAR(grazing_mirror.fresnel, 1, 1e-15);
            const auto normal = terms_at(kAll, 1, 0.5, u, phi);
            EXPECT_TRUE(std::isfinite(normal.weight) && std::isfinite(normal.fresnel) &&
                        std::isfinite(normal.deficit));
        }
        const auto grazing = terms_at(kAll, 0, 0.5, u, 1.0);
        EXPECT_NEAR(grazing.weight, 1, 1e-15);  // correlated Smith: all light comes back
    }
}

// One lane in float, over every stiff corner: nothing that is not a number, nothing outside [0, 1].
TEST(Integrand, FloatStaysInItsRangeOverRandomExtremes) {
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> exponent(-6, 0), uniform(0, 1);
    const in_float::Integrand what = {KILN_MASKING_SMITH_CORRELATED, KILN_IMPORTANCE_VNDF, 7};
    constexpr float kSlack = 2e-6f;  // some twenty roundings of 6e-8
    for (int i = 0; i < 300000; ++i) {
        const auto NoV = static_cast<float>(i % 7 == 0    ? 0
                                            : i % 11 == 0 ? 1
                                                          : std::pow(10, exponent(random)));
        const auto alpha = static_cast<float>(i % 5 == 0    ? 0
                                              : i % 13 == 0 ? 1
                                                            : std::pow(10, exponent(random)));
        const double u = i % 3 == 0    ? 0.5 / 4294967296.0
                         : i % 17 == 0 ? 1 - 0.5 / 4294967296.0
                                       : uniform(random);
        const in_float::View view = in_float::ggx_view(NoV, alpha);
        const double cosine = i % 4 == 0 ? -1 : std::cos(3.14159265 * uniform(random));
        const auto in_full = kiln::visible_normal_point(cosine, u);
        const float point[] = {static_cast<float>(in_full[0]), static_cast<float>(in_full[1])};
        const auto h = in_float::ggx_sample_vndf(view, point);
        const auto NoH = static_cast<float>(KILN_VISIBLE_NOH);
        const auto terms = in_float::weigh(what, view, h, in_float::ggx_mirror(view, h, NoH),
                                           in_float::ggx_one_minus_VoH(view, h), 0);
        for (const float value : {terms.weight, terms.fresnel, terms.deficit}) {
            ASSERT_TRUE(std::isfinite(value)) << NoV << " " << alpha << " " << u << " " << cosine;
            ASSERT_GE(value, -kSlack) << NoV << " " << alpha << " " << u << " " << cosine;
            ASSERT_LE(value - 1, kSlack)
                << NoV << " " << alpha << " " << u << " " << cosine << " : " << terms.weight - 1
                << " " << terms.fresnel << " " << terms.deficit;
        }
    }
}
