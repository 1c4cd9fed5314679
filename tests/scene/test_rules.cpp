// SPDX-License-Identifier: Apache-2.0
#include "server/scene/rules.h"

#include <gtest/gtest.h>

#include <cmath>

#include "server/compute/fresnel.h"
#include "server/compute/multiscatter.h"
#include "server/scene/bounds.h"
#include "tests/reference/reference.h"

namespace kiln::rules {
namespace {

constexpr std::int64_t kRows = 64;

Need need_of(Lobe lobe, Range roughness, Range f0 = {0.04, 0.04}, Range f90 = {1, 1}) {
    return {lobe, 0, roughness, {f0, f0, f0}, f90, true};
}

std::vector<std::pair<double, double>> ends(const std::vector<Range>& pieces) {
    std::vector<std::pair<double, double>> result;
    for (const Range& piece : pieces) result.emplace_back(piece.lo, piece.hi);
    return result;
}
using Ends = std::vector<std::pair<double, double>>;

TEST(Rules, OnlyLitLobesOfUsedMaterialsNeedAnything) {
    SceneUse scene;
    MaterialUse lit, unlit, measured;
    lit.lobes.add(Lobe::metal);
    lit.lobes.add(Lobe::clearcoat);
    lit.roughness = {0.029999999329447746, 0.029999999329447746};
    lit.clearcoat_roughness = {0.03, 0.03};
    unlit = measured = lit;
    unlit.unlit = true;
    measured.measured = "sha256:x";
    scene.materials = {unlit, lit, measured};
    const auto needs = needs_of(scene);
    ASSERT_EQ(needs.size(), 2u);
    EXPECT_EQ(needs[0].material, 1u);
    EXPECT_EQ(needs[0].lobe, Lobe::metal);
    EXPECT_EQ(needs[1].lobe, Lobe::clearcoat);
    // One number to a 32-bit exporter, one to the plan.
    EXPECT_EQ(needs[0].roughness.lo, needs[1].roughness.lo);
    EXPECT_EQ(needs[1].f0[0].lo, 0.04);
    EXPECT_TRUE(reads_tables(lit));
    EXPECT_FALSE(reads_tables(unlit));
    EXPECT_FALSE(reads_tables(measured));
}

TEST(Rules, NoNeedOfALobeNoTableOfIt) {
    const std::vector<Need> needs{need_of(Lobe::metal, {0, 1}), need_of(Lobe::sheen, {0, 1}),
                                  need_of(Lobe::metal, {1, 1})};
    EXPECT_EQ(needs_with(needs, {Lobe::metal}).size(), 2u);
    EXPECT_EQ(needs_with(needs, {Lobe::sheen, Lobe::diffuse}).at(0).lobe, Lobe::sheen);
    EXPECT_TRUE(needs_with(needs, {Lobe::diffuse, Lobe::clearcoat}).empty());
}

TEST(Rules, AFilmLeavesTheReflectanceOpenButNotTheCoats) {
    SceneUse scene;
    MaterialUse film;
    for (const Lobe lobe : {Lobe::dielectric, Lobe::clearcoat, Lobe::iridescence})
        film.lobes.add(lobe);
    scene.materials = {film};
    const auto needs = needs_of(scene);
    ASSERT_EQ(needs.size(), 2u);
    EXPECT_FALSE(one_reflectance({needs[0]}));
    EXPECT_TRUE(one_reflectance({needs[1]}));
}

TEST(Rules, APieceIsARowAPartOrTheWholeAxis) {
    EXPECT_TRUE(is_row({0.4, 0.4}));
    EXPECT_FALSE(is_row({0.4, 0.41}));
    EXPECT_TRUE(is_part({0.4, 0.7}, 0));
    EXPECT_TRUE(is_part({0, 0.9}, 0));
    EXPECT_FALSE(is_part({0, 1}, 0));
    EXPECT_FALSE(is_part({0.07, 1}, 0.07));
    EXPECT_FALSE(is_part({0.4, 0.4}, 0));
}

TEST(Rules, EqualTablesAreOne) {
    EXPECT_EQ(equal_tables(5, 2), 3u);
    EXPECT_EQ(equal_tables(1, 1), 0u);
    // A range and a value within it are one piece; two values far apart are none.
    EXPECT_EQ(equal_tables(2, roughness_pieces({{0.2, 0.6}, {0.4, 0.4}}, kRows).size()), 1u);
    EXPECT_EQ(equal_tables(2, roughness_pieces({{0.2, 0.2}, {0.9, 0.9}}, kRows).size()), 0u);
}

TEST(Rules, TheAverageIsReadBesideAAndBAlone) {
    const Reflectance white{1, 1};
    EXPECT_TRUE(reads_average(Multiscatter::kulla_conty, {}));
    EXPECT_TRUE(reads_average(Multiscatter::kulla_conty_linear, {}));
    EXPECT_FALSE(reads_average(Multiscatter::kulla_conty, white));
    EXPECT_FALSE(reads_average(Multiscatter::turquin, {}));
    EXPECT_FALSE(reads_average(Multiscatter::none, {}));
}

TEST(Rules, OneRoughnessIsOneRow) {
    EXPECT_EQ(ends(roughness_pieces({{0.4, 0.4}}, kRows)), (Ends{{0.4, 0.4}}));
    EXPECT_EQ(rows_of({0.4, 0.4}, kRows), 1);
    EXPECT_EQ(ends(roughness_pieces({{0.7, 0.7}, {0.4, 0.4}, {0.7, 0.7}}, kRows)),
              (Ends{{0.4, 0.4}, {0.7, 0.7}}));
}

TEST(Rules, ARangeIsAnAxisOverThatRangeAlone) {
    EXPECT_EQ(ends(roughness_pieces({{0.4, 0.7}}, kRows)), (Ends{{0.4, 0.7}}));
    // 0.3 of 63 steps are 18.9: 19 steps between 20 nodes are no wider than the full axis's.
    EXPECT_EQ(rows_of({0.4, 0.7}, kRows), 20);
    EXPECT_EQ(rows_of({0, 1}, kRows), kRows);
    EXPECT_EQ(rows_of({0.5, 0.5000001}, kRows), 2);
    for (double lo = 0; lo < 0.9; lo += 0.1)
        EXPECT_LE(0.1 / static_cast<double>(rows_of({lo, lo + 0.1}, kRows) - 1), 1.0 / 63) << lo;
}

TEST(Rules, EqualAndOverlappingTablesAreOne) {
    EXPECT_EQ(ends(roughness_pieces({{0.2, 0.5}, {0.4, 0.7}, {0.6, 0.6}}, kRows)),
              (Ends{{0.2, 0.7}}));
    EXPECT_EQ(ends(roughness_pieces({{0, 1}, {0.3, 0.3}, {0, 0}}, kRows)), (Ends{{0, 1}}));
    EXPECT_EQ(ends(roughness_pieces({{0, 0.1}, {0.8, 0.9}, {0.5, 0.5}}, kRows)),
              (Ends{{0, 0.1}, {0.5, 0.5}, {0.8, 0.9}}));
    EXPECT_TRUE(roughness_pieces({}, kRows).empty());
}

TEST(Rules, ManyRowsBecomeARangeWhenThatIsLess) {
    std::vector<Range> close, many;
    for (int i = 0; i < 4; ++i) close.push_back({0.5 + 0.01 * i, 0.5 + 0.01 * i});
    // 0.03 of 63 steps are two steps, three rows: fewer than four.
    EXPECT_EQ(roughness_pieces(close, kRows).size(), 1u);
    for (std::size_t i = 0; i < kRowsMax; ++i)
        many.push_back({static_cast<double>(i) / 10, static_cast<double>(i) / 10});
    EXPECT_EQ(roughness_pieces(many, kRows).size(), kRowsMax);
    many.push_back({0.95, 0.95});
    EXPECT_EQ(ends(roughness_pieces(many, kRows)), (Ends{{0, 0.95}}));
}

TEST(Rules, OneReflectanceIsOneChannel) {
    const Need coat = need_of(Lobe::clearcoat, {0, 1});
    EXPECT_EQ(one_reflectance({coat, coat}), (Reflectance{0.04, 1}));
    EXPECT_FALSE(one_reflectance({coat, need_of(Lobe::metal, {0, 1}, {1, 1})}));
    EXPECT_FALSE(
        one_reflectance({coat, need_of(Lobe::dielectric, {0, 1}, {0.04, 0.04}, {0.5, 0.5})}));
    EXPECT_FALSE(one_reflectance({need_of(Lobe::metal, {0, 1}, {0, 1})}));
    EXPECT_FALSE(one_reflectance({need_of(Lobe::dielectric, {0, 1}, {0.04, 0.04}, {0, 1})}));
    Need gold = need_of(Lobe::metal, {0.3, 0.3}, {1, 1});
    gold.f0[2] = {0.3, 0.3};
    EXPECT_FALSE(one_reflectance({gold}));
    EXPECT_FALSE(one_reflectance({}));
}

TEST(Rules, AMirrorNeedsNoTable) {
    EXPECT_TRUE(is_mirror({0, 0}));
    EXPECT_FALSE(is_mirror({0, 0.1}));
    EXPECT_FALSE(is_mirror({0.01, 0.01}));
}

TEST(Rules, LambertNeedsNoTable) {
    EXPECT_FALSE(diffuse_needs_table(DiffuseModel::none));
    EXPECT_FALSE(diffuse_needs_table(DiffuseModel::lambert));
    EXPECT_TRUE(diffuse_needs_table(DiffuseModel::burley));
    EXPECT_TRUE(diffuse_needs_table(DiffuseModel::eon));
}

TEST(Rules, HalfAQuantumIsThatOfTheCodes) {
    EXPECT_EQ(half_quantum(PixelType::uint8) * 2 * 255, 1);
    EXPECT_EQ(half_quantum(PixelType::uint16) * 2 * 65535, 1);
    EXPECT_EQ(half_quantum(PixelType::half), 0.5 / 2048);
    EXPECT_EQ(half_quantum(PixelType::float32), (1 - std::nextafter(1.0f, 0.0f)) / 2);
}

// By quadrature that shares no line with the kernels, over NoV as dense near the horizon as near
// the normal.
TEST(Rules, TheDeficitsBoundHoldsAndIsNoWiderThanItsStep) {
    EXPECT_EQ(deficit_most(0), 0);
    double last = 0;
    for (int i = 1; i <= 20; ++i) {
        const double roughness = i / 20.0, alpha = roughness * roughness;
        double most = 0;
        for (int k = 1; k <= 40; ++k) {
            const double NoV = std::max(std::pow(k / 40.0, 3), 1e-4);
            most = std::max(most, reference::deficit(NoV, std::max(alpha, 1e-4),
                                                     reference::Masking::correlated));
        }
        EXPECT_LE(most, deficit_most(roughness)) << roughness;
        // The next step is at most 0.1 further on: 1 − E rises by at most 0.14 there.
        EXPECT_GE(most, deficit_most(roughness) - 0.14) << roughness;
        EXPECT_GE(deficit_most(roughness), last);
        last = deficit_most(roughness);
    }
}

TEST(Rules, WhatCompensationAddsIsBounded) {
    FresnelModel schlick;
    for (const double F0 : {0.0, 0.04, 0.5, 1.0}) {
        schlick.f0 = {F0};
        for (const double roughness : {0.2, 0.6, 1.0}) {
            const std::vector<Need> needs{
                need_of(Lobe::dielectric, {0, roughness}, {0, F0}, {1, 1})};
            const double alpha = roughness * roughness;
            const double missing =
                reference::average_deficit(alpha, reference::Masking::correlated);
            for (const double NoV : {0.05, 0.2, 0.5, 0.9}) {
                const auto masking = reference::Masking::correlated;
                const double deficit = reference::deficit(NoV, alpha, masking);
                const auto split = reference::split_sum(NoV, alpha, masking);
                const double average = fresnel_average(schlick, 0);
                const double E = split.scale + split.bias;
                const double S = F0 * split.scale + split.bias;
                EXPECT_LE(multiscatter_fresnel(false, average, missing) * deficit,
                          multiscatter_most(needs, Multiscatter::kulla_conty) + 1e-12);
                EXPECT_LE(multiscatter_fresnel(true, average, missing) * deficit,
                          multiscatter_most(needs, Multiscatter::kulla_conty_linear) + 1e-12);
                EXPECT_LE(S * (turquin_scale(F0, E) - 1),
                          multiscatter_most(needs, Multiscatter::turquin) + 1e-12);
            }
        }
    }
}

TEST(Rules, CompensationBelowHalfAQuantumIsInvisible) {
    const auto most = [](double roughness, Range f0) {
        return multiscatter_most({need_of(Lobe::dielectric, {roughness, roughness}, f0)},
                                 Multiscatter::kulla_conty);
    };
    const double byte = half_quantum(PixelType::uint8), half = half_quantum(PixelType::half);
    EXPECT_LE(most(0.5, {0.04, 0.04}), byte);
    EXPECT_GT(most(1, {0.04, 0.04}), byte);
    EXPECT_GT(most(0.5, {0.04, 0.04}), half);
    EXPECT_GT(most(0.1, {1, 1}), byte);
    EXPECT_EQ(most(0, {1, 1}), 0);
    EXPECT_EQ(multiscatter_most({need_of(Lobe::metal, {0, 1}, {1, 1})}, Multiscatter::none), 0);
    const std::vector<Need> needs{need_of(Lobe::dielectric, {0.5, 0.5})};
    EXPECT_TRUE(compensation_is_invisible(needs, Multiscatter::kulla_conty, PixelType::uint8));
    EXPECT_FALSE(compensation_is_invisible(needs, Multiscatter::kulla_conty, PixelType::half));
}

TEST(Rules, MeasuredMaterialsThatNothingUsesAreNamed) {
    SceneUse scene;
    MaterialUse a, b;
    a.measured = "one";
    b.measured = "one";
    scene.materials = {a, b, MaterialUse{}};
    scene.unused = {
        {3, "x", "", "two"}, {4, "y", "", "one"}, {5, "z", "", ""}, {6, "w", "", "two"}};
    const MeasuredUse use = measured_use(scene);
    EXPECT_EQ(use.used, (std::vector<std::string>{"one"}));
    EXPECT_EQ(use.unused, (std::vector<std::string>{"two"}));
}

}  // namespace
}  // namespace kiln::rules
