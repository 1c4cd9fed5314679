// SPDX-License-Identifier: Apache-2.0
// Analytic models fitted to files that are written from them, and pictures of materials.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "server/image/image.h"
#include "server/measured/fits.h"
#include "server/measured/views.h"
#include "tests/measured/synthetic.h"

namespace kiln {
namespace {

using namespace measured;

LobeTables tables_of(const synthetic::Material& surface, double step = 2.5) {
    synthetic::MiniDiffGrid grid;
    grid.azimuth_step = grid.radial_step = step;
    Reading reading = read_measurement(synthetic::minidiff_file(surface, grid));
    return make_lobe_tables(Material(reading.components[0], {}, reading.understood));
}

/// What steps of 2.5 degrees leave of a lobe as narrow as alpha = 0.2 is 0.6 % of its peak
/// ((2.5 degrees / alpha)^2 / 8), and less of wider ones.
TEST(Fits, GgxGivesItsParametersBack) {
    Resampler resampler;
    for (const double alpha : {0.2, 0.5}) {
        const Colour f0 = {0.6, 0.3, 0.04}, diffuse = {0.1, 0.2, 0.4};
        const LobeTables tables = tables_of(synthetic::ggx(alpha, f0, diffuse));
        const Fit fit = fit_model(FitModel::ggx_diffuse, tables, resampler);
        EXPECT_NEAR(fit.width / alpha, 1, 0.01);
        EXPECT_EQ(fit.f90, 1);
        for (std::size_t k = 0; k < 3; ++k) {
            EXPECT_NEAR(fit.f0[k], f0[k], 0.01 * f0[k] + 0.002) << alpha << " " << k;
            EXPECT_NEAR(fit.diffuse[k], diffuse[k], 0.01) << alpha << " " << k;
        }
        EXPECT_LT(fit.error, 0.01);
        EXPECT_TRUE(offered(tables, 0.02, resampler).has_value());
        EXPECT_FALSE(offered(tables, 1e-5, resampler).has_value());
    }
}

TEST(Fits, ALambertianHasNoLobe) {
    Resampler resampler;
    const Fit fit = fit_model(FitModel::ggx_diffuse,
                              tables_of(synthetic::lambert({0.3, 0.5, 0.7}), 5), resampler);
    EXPECT_LT(fit.error, 1e-3);
    EXPECT_LT(fit.f90 * fit.width, 0.02);
    EXPECT_NEAR(fit.diffuse[1], 0.5, 0.002);
}

TEST(Fits, PhongGivesItsParametersBack) {
    const synthetic::Material phong = [](const synthetic::Cosines& c) {
        const double LoV = 2 * c.VoH * c.VoH - 1, VoR = 2 * c.NoL * c.NoV - LoV;
        const double lobe = 22 / (2 * std::numbers::pi) * std::pow(std::max(0.0, VoR), 20.0);
        return std::array{0.3 / std::numbers::pi + 0.5 * lobe, 0.2 / std::numbers::pi + 0.4 * lobe,
                          0.1 / std::numbers::pi + 0.3 * lobe};
    };
    Resampler resampler;
    const LobeTables tables = tables_of(phong);
    const Fit fit = fit_model(FitModel::lafortune_phong, tables, resampler);
    EXPECT_NEAR(fit.width, 20, 0.2);
    EXPECT_NEAR(fit.f0[0], 0.5, 0.005);
    EXPECT_NEAR(fit.diffuse[2], 0.1, 0.005);
    // GGX is another shape: its ends are soft, as the paper's figure 7 shows.
    const Fit other = fit_model(FitModel::ggx_diffuse, tables, resampler);
    EXPECT_GT(other.error, 5 * fit.error);
    const Table map = error_map(other, tables, {0, 40}, 91, 46, resampler);
    const Table own = error_map(fit, tables, {0, 40}, 91, 46, resampler);
    const auto most = [](const Table& table) {
        float value = 0;
        for (const float v : table.planes[0]) value = std::max(value, std::abs(v));
        return value;
    };
    EXPECT_GT(most(map), 0.2f);
    EXPECT_LT(most(own), 0.05f);
}

struct Image {
    Decoded decoded;
    Colour at(double x, double y) const {
        const auto n =
            static_cast<std::size_t>(y) * decoded.table.width + static_cast<std::size_t>(x);
        Colour c{};
        for (std::size_t k = 0; k < 3; ++k) c[k] = decoded.table.planes[k][n];
        return c;
    }
};
bool is_paper(const Colour& c) { return c[0] > 0.95 && c[1] > 0.95 && c[2] > 0.95; }

/// A Lambertian lobe is half a sphere: every direction is equally long.
TEST(Views, ALambertianLobeIsHalfASphere) {
    Resampler resampler;
    const LobeTables tables = tables_of(synthetic::lambert({0.9, 0.2, 0.1}), 5);
    const View view = lobe_view(tables, 40, {400, 300, ""}, resampler);
    const Image image{decode(png_of(view.picture, view.words))};
    ASSERT_EQ(image.decoded.table.width, 400u);
    ASSERT_EQ(image.decoded.table.height, 300u);
    const double x = 200, y = 0.69 * 300, radius = 0.43 * 400;
    // Above the origin, away from the rays: the half sphere's red, then paper.
    for (const double turn : {60.0, 75.0, 100.0, 120.0}) {
        const double c = std::cos(turn * kDegree), s = std::sin(turn * kDegree);
        const Colour inside = image.at(x + 0.96 * radius * c, y - 0.96 * radius * s);
        EXPECT_FALSE(is_paper(inside)) << turn;
        EXPECT_GT(inside[0], 1.2 * inside[1]) << turn;
        EXPECT_TRUE(is_paper(image.at(x + 1.04 * radius * c, y - 1.04 * radius * s))) << turn;
    }
}

TEST(Views, NearSurfacesHideFarOnes) {
    const Colour red = {1, 0, 0}, green = {0, 1, 0};
    for (const bool red_first : {false, true}) {
        Canvas canvas(8, 8, {1, 1, 1});
        const auto draw = [&](const Colour& colour, double near) {
            canvas.triangle({-20, -20, near, colour}, {40, -20, near, colour},
                            {-20, 40, near, colour});
        };
        if (red_first) draw(red, 1);
        draw(green, 2);
        if (!red_first) draw(red, 1);
        const Picture picture = canvas.picture();
        EXPECT_EQ(picture.rgb[0], 0) << red_first;
        EXPECT_EQ(picture.rgb[1], 255) << red_first;
    }
}

TEST(Views, ASphereIsLitFromAbove) {
    Resampler resampler;
    const LobeTables tables = tables_of(synthetic::ggx(0.3, {0.2, 0.2, 0.2}, {0.1, 0.3, 0.5}), 3);
    const View view = sphere_view(tables, {96, 96, ""}, resampler);
    const Image image{decode(png_of(view.picture, {}))};
    const Colour top = image.at(40, 20), bottom = image.at(48, 86), outside = image.at(2, 2);
    EXPECT_GT(top[1], bottom[1]);
    EXPECT_GT(bottom[2], bottom[0]);  // the blue of its diffuse part
    EXPECT_EQ(outside[0], outside[2]);
    for (const std::vector<float>& plane : image.decoded.table.planes)
        for (const float v : plane) ASSERT_TRUE(v >= 0 && v <= 1);
}

}  // namespace
}  // namespace kiln
