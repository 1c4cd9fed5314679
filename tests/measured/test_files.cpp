// SPDX-License-Identifier: Apache-2.0
// Real files, against the figures that were found in them by other programs (the README beside
// the files). Values in a README are rounded to three digits, so half of the last one is allowed.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "server/base/error.h"
#include "server/measured/rgl_brdf.h"
#include "tests/measured/files.h"
#include "tests/measured/synthetic.h"

namespace kiln {
namespace {

using namespace measured;
using namespace measured_files;

/// Integral of the stored quantity over the hemisphere, clamped at zero, by the midpoint rule over
/// half vectors with d omega_o = 4 (i.h) d omega_h.
std::array<double, 3> albedo(const RglBrdf& brdf, double theta_i) {
    constexpr int kRings = 300, kSpokes = 360;
    const Vec in = direction(theta_i, 0);
    std::array<double, 3> sum{};
    for (int ring = 0; ring < kRings; ++ring)
        for (int spoke = 0; spoke < kSpokes; ++spoke) {
            const double u = (ring + 0.5) / kRings, v = (spoke + 0.5) / kSpokes;
            const Vec half = RglBrdf::half_vector(u, v);
            const double d = dot(in, half);
            const Vec out = 2 * d * half - in;
            if (d <= 0 || out.z <= 0) continue;
            const double theta_h = u * u * std::numbers::pi / 2;
            const double area =
                std::sin(theta_h) * u * std::numbers::pi / kRings * 2 * std::numbers::pi / kSpokes;
            const auto value = brdf.value(in, out);
            for (std::size_t c = 0; c < 3; ++c) sum[c] += 4 * d * area * std::max(0.0, value[c]);
        }
    return sum;
}

struct RglFile {
    const char* name;
    std::array<std::array<double, 3>, 5> albedo;  ///< at 0, 30, 60, 75, 85 degrees
    const char* mask;
};
const RglFile kRgl[] = {
    {"rgl/paper_white_rgb.bsdf",
     {{{.819, .834, .980},
       {.826, .839, .980},
       {.857, .865, .994},
       {.816, .822, .938},
       {.792, .798, .908}}},
     "bit 1 is below the horizon"},
    {"rgl/satin_rosaline_rgb.bsdf",
     {{{.666, .717, .715},
       {.699, .733, .733},
       {.744, .779, .764},
       {.996, 1.005, .973},
       {1.156, 1.148, 1.104}}},
     "bit 1 is below the horizon"},
    {"rgl/cg_sunflower_rgb.bsdf",
     {{{.853, .404, .010},
       {.816, .403, .024},
       {.746, .392, .033},
       {.589, .310, .029},
       {.532, .279, .029}}},
     "bit 1 is above the horizon"},
    {"rgl/cc_iris_purple_gem_rgb.bsdf",
     {{{.015, .160, .354},
       {.050, .099, .332},
       {.192, .115, .213},
       {.299, .265, .286},
       {.435, .417, .424}}},
     "bit 1 is above the horizon"},
};

TEST_F(Files, RglHasTheAlbedosOfItsReadme) {
    const std::array<double, 5> theta = {0, 30, 60, 75, 85};
    for (const RglFile& file : kRgl) {
        const std::string bytes = bytes_of(file.name);
        const RglBrdf brdf(bytes);
        for (std::size_t t = 0; t < theta.size(); ++t) {
            const auto found = albedo(brdf, theta[t]);
            // Half a digit, and half of one for the two quadratures.
            for (std::size_t c = 0; c < 3; ++c)
                EXPECT_NEAR(found[c], file.albedo[t][c], 0.001) << file.name << " " << theta[t];
        }
    }
}

TEST_F(Files, RglTrapsAreKnownForWhatTheyAre) {
    for (const RglFile& file : kRgl) {
        const Reading reading = reading_of(file.name);
        EXPECT_EQ(finding(reading.understood, "convention"), "f cos theta_o") << file.name;
        EXPECT_EQ(finding(reading.understood, "mask"), file.mask) << file.name;
        ASSERT_EQ(reading.understood.left_out.size(), 1u);
        EXPECT_EQ(reading.understood.left_out[0].what, "theta_i = 90 degrees");
        // Eight slices in the file, the copied one left out.
        const ComponentSurvey part = survey(reading.components[0]);
        EXPECT_EQ(part.incidence_count, 7u);
        EXPECT_LT(part.incidences.back().theta_i, 81);
        EXPECT_LT(part.theta_out_max, 88.1);
    }
}

/// Reciprocity as it is, and with the cosine put back: what a reader that takes the stored value
/// for f would have made.
TEST_F(Files, RglIsReciprocalOnlyWithoutTheCosine) {
    for (const RglFile& file : kRgl) {
        Component part = reading_of(file.name).components[0];
        const ReciprocityError after = survey(part).reciprocity;
        for (std::size_t n = 0; n < part.cloud.size(); ++n)
            for (std::size_t c = 0; c < 3; ++c)
                part.cloud.values[3 * n + c] *=
                    static_cast<float>(std::cos(part.cloud.theta_o[n] * kDegree));
        const ReciprocityError before = survey(part).reciprocity;
        ASSERT_GT(after.pairs, 400u);
        EXPECT_LT(after.median, before.median) << file.name;
        // The iridescent film is measured least well (a median of .22 in the facts about it).
        if (std::string(file.name).find("iris") == std::string::npos) {
            EXPECT_LT(after.median, 0.03) << file.name;
            EXPECT_GT(before.median, 10 * after.median) << file.name;
        }
    }
}

/// What the cloud holds is what the file defines, but for the two degrees at the horizon. These
/// hold at most 1 - sin^2 88 = .12 % of a Lambertian albedo and the stored value does not vanish
/// there: at most twice its mean over the last ten degrees was found, 1 % of the albedo.
TEST_F(Files, RglCloudsHoldTheAlbedoOfTheirFiles) {
    for (const RglFile& file : kRgl) {
        const std::string bytes = bytes_of(file.name);
        const RglBrdf brdf(bytes);
        const ComponentSurvey part = survey(read_measurement(bytes).components[0]);
        for (const IncidenceSurvey& one : part.incidences) {
            const auto whole = albedo(brdf, one.theta_i);
            EXPECT_GT(one.coverage, 0.99);
            EXPECT_NEAR(one.albedo[1], whole[1], 0.012 * whole[1] + 0.0005)
                << file.name << " " << one.theta_i;
        }
    }
}

/// The integral as the README took it: bilinear cells about the mirror direction, zeros and all.
double zemax_integral(const std::string& text, std::size_t aoi) {
    Cloud cloud = read_measurement(text).components[0].cloud;
    // Rows follow one another: [azimuth][radial], of half a turn or of a whole one; of several
    // rotations of the sample the first comes first, and mirrored points come last.
    const bool half = text.find("\nScatterAzimuth\t19") != text.npos;
    std::vector<double> radial = {0, 5, 10, 15, 20, 30, 40, 50, 60, 70, 80, 90};
    if (!half)
        for (double r = 100; r <= 180; r += 10) radial.push_back(r);
    const std::size_t azimuths = half ? 19 : 37, radials = radial.size();
    const auto value = [&](std::size_t a, std::size_t r) {
        return static_cast<double>(cloud.values[(aoi * azimuths + a) * radials + r]);
    };
    const double theta_i = cloud.theta_i[aoi * azimuths * radials];
    double sum = 0;
    constexpr double kStep = 0.5;
    for (double a = kStep / 2; a < (half ? 180 : 360); a += kStep)
        for (double r = kStep / 2; r < radial.back(); r += kStep) {
            std::size_t k = 0;
            while (radial[k + 1] <= r) ++k;
            const double s = (r - radial[k]) / (radial[k + 1] - radial[k]);
            const auto row = static_cast<std::size_t>(a / 10);
            const double t = a / 10 - static_cast<double>(row);
            const double f = (1 - t) * ((1 - s) * value(row, k) + s * value(row, k + 1)) +
                             t * ((1 - s) * value(row + 1, k) + s * value(row + 1, k + 1));
            const Vec out = about_mirror(theta_i, 0, r, a);
            if (out.z > 0)
                sum += (half ? 2 : 1) * f * out.z * std::sin(r * kDegree) * kStep * kDegree *
                       kStep * kDegree;
        }
    return sum;
}

TEST_F(Files, ZemaxHasTheIntegralsOfItsReadme) {
    const std::pair<const char*, std::array<double, 4>> files[] = {
        {"zemax/AnoBlackEC1onAlum.bsdf", {.0507, .0494, .0499, .0818}},
        {"zemax/AnoBlackEC2onAlum.bsdf", {.0498, .0480, .0483, .0663}},
        {"zemax/AnoBlackNiTEonINVAR.bsdf", {.0630, .0598, .0599, .0896}},
        {"zemax/IMX455.bsdf", {.0360, .0188, .0364, .1048}},
    };
    for (const auto& [name, integrals] : files) {
        const std::string text = bytes_of(name);
        // Half a digit of the README and one for steps of half a degree.
        for (std::size_t aoi = 0; aoi < 4; ++aoi)
            EXPECT_NEAR(zemax_integral(text, aoi), integrals[aoi], 1.5e-4) << name << aoi;
    }
}

/// Rings summed as rectangles of a degree by two, as the README took them: the last ring stands
/// for half a degree more than a triangulation of the points does.
TEST_F(Files, LightToolsHasTheIntegralsOfItsReadme) {
    const std::pair<const char*, std::array<double, 4>> files[] = {
        {"derived_minidiff_layout/satin_rosaline_minidiff_layout.bsdf", {.687, .686, .711, .743}},
        {"derived_minidiff_layout/cg_sunflower_minidiff_layout.bsdf", {.373, .382, .392, .415}},
    };
    for (const auto& [name, integrals] : files) {
        const Reading reading = reading_of(name);
        EXPECT_EQ(finding(reading.understood, "azimuth"), "light at 90 degrees");
        const Cloud& cloud = reading.components[0].cloud;
        EXPECT_EQ(cloud.channels, (std::vector<std::string>{"630nm", "525nm", "465nm"}));
        std::array<double, 4> sum{};
        for (std::size_t n = 0; n < cloud.size(); ++n) {
            if (n % (181 * 76) >= 180 * 76) continue;  // the azimuth 360 repeats 0
            const double theta = cloud.theta_o[n] * kDegree;
            sum[n / (181 * 76)] +=
                cloud.values[3 * n + 1] * std::cos(theta) * std::sin(theta) * kDegree * 2 * kDegree;
        }
        for (std::size_t n = 0; n < 4; ++n) EXPECT_NEAR(sum[n], integrals[n], 0.001) << name << n;
    }
}

TEST_F(Files, LbnlHasTheReflectancesOfItsReadme) {
    const Reading reading = reading_of("lbnl_xml/2011-SA1.XML");
    std::map<std::string, double> albedo_of;
    for (const Component& part : reading.components) {
        const ComponentSurvey found = survey(part);
        albedo_of[part.name] = found.incidences[0].albedo[0];
        // The patches of Klems are the hemisphere.
        EXPECT_NEAR(found.incidences[0].coverage, 1.0, 1e-6);
    }
    EXPECT_EQ(reading.components[0].name, "reflection front, visible");
    EXPECT_NEAR(albedo_of["reflection front, visible"], .4825, 6e-5);
    EXPECT_NEAR(albedo_of["reflection back, visible"], .5600, 6e-5);
    EXPECT_NEAR(albedo_of["transmission front, visible"], .0959, 6e-5);
    EXPECT_NEAR(albedo_of["reflection front, solar"], .4654, 6e-5);
}

TEST_F(Files, SinglePointsHaveTheValuesOfTheirReadme) {
    const Reading bird = reading_of("bird_json/example.brdf");
    ASSERT_EQ(bird.components[0].cloud.size(), 1u);
    // Pairs of polarisations: (.254 + .263) / 2 and so on.
    const std::array<double, 4> means = {.2585, .2700, .2880, .2985};
    for (std::size_t c = 0; c < 4; ++c)
        EXPECT_NEAR(bird.components[0].cloud.values[c], means[c], 1e-6);
    const Reading spectralon = reading_of("spectralon_blacklab/20250210_S7_sample_final.txt");
    const Cloud& cloud = spectralon.components[0].cloud;
    EXPECT_EQ(cloud.channels[4], "537.85nm");
    EXPECT_NEAR(cloud.values[4], 1.015793 / std::numbers::pi, 1e-6);
    EXPECT_EQ(finding(spectralon.understood, "convention"), "reflectance factor, divided by pi");
}

TEST_F(Files, EveryFileIsReadOrRefusedWithAReason) {
    std::map<std::string, int> count;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder())) {
        if (!entry.is_regular_file()) continue;
        const std::string name = std::filesystem::relative(entry.path(), folder()).string();
        const std::string top = name.substr(0, name.find('/'));
        if (top == name || name.find("LICENSE") != std::string::npos) continue;
        const bool raw = top == "rt300s_raw" || top == "rt300s_exports" || top == "nk" ||
                         top == "fits" || top == "cie";
        try {
            reading_of(name);
            EXPECT_FALSE(raw) << name;
            ++count["read"];
        } catch (const Error& error) {
            EXPECT_TRUE(raw) << name << ": " << error.what();
            EXPECT_EQ(error.code(), "unreadable_measurement") << name << ": " << error.what();
            ++count["refused"];
        }
    }
    EXPECT_EQ(count["read"], 16);
    EXPECT_GE(count["refused"], 30);
}

}  // namespace
}  // namespace kiln
