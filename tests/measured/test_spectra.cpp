// SPDX-License-Identifier: Apache-2.0
// Spectral tensor files: the colour of known reflectances, and the shape of a known surface.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "server/base/error.h"
#include "server/measured/observer.h"
#include "tests/measured/files.h"
#include "tests/measured/synthetic.h"

namespace kiln {
namespace {

using namespace measured;
using Rgb = std::array<double, 3>;

std::vector<double> every(double from, double to, double step) {
    std::vector<double> list;
    for (double at = from; at <= to; at += step) list.push_back(at);
    return list;
}

/// Rises within some 40 nm.
double edge(double nm, double at) { return 1 / (1 + std::exp(-(nm - at) / 20)); }

struct Known {
    const char* name;
    double (*reflectance)(double);
    Rgb srgb;
};
// Sums over the CIE's own tables (x, y, z of the 2 degree observer of 1931 and D65, every 5 nm)
// with the matrix of IEC 61966-2-1: what benchmarks/observer.py prints.
constexpr Known kKnown[] = {
    {"white", [](double) { return 1.0; }, {1, 1, 1}},
    {"red", [](double nm) { return edge(nm, 590); }, {0.9210, 0.1029, -0.0282}},
    {"yellow", [](double nm) { return edge(nm, 510); }, {1.1360, 0.7931, -0.0098}},
    {"blue", [](double nm) { return 1 - edge(nm, 490); }, {-0.0600, 0.0765, 0.9098}},
    {"green",
     [](double nm) { return edge(nm, 490) * (1 - edge(nm, 570)); },
     {-0.0549, 0.7048, 0.1357}},
    {"ripples", [](double nm) { return 0.5 + 0.4 * std::sin(nm / 15); }, {0.5525, 0.4707, 0.3481}},
};

/// The lobes are within 0.001 of the tables, as their script says. Lines between samples lower the
/// ripples, 0.4 sin(nm / 15), the sharpest of these, by (step / 15)^2 / 12.
TEST(Observer, SeesTheColoursOfTheTables) {
    for (const Known& known : kKnown)
        for (const double step : {1.0, 3.32, 10.0, 20.0}) {
            const std::vector<double> nm = every(358, 1002, step);
            const auto weights = srgb_weights(nm);
            Rgb seen{};
            for (std::size_t n = 0; n < nm.size(); ++n)
                for (std::size_t k = 0; k < 3; ++k)
                    seen[k] += weights[n][k] * known.reflectance(nm[n]);
            const double bound = 0.0012 + 0.4 * (step / 15) * (step / 15) / 12;
            for (std::size_t k = 0; k < 3; ++k)
                EXPECT_NEAR(seen[k], known.srgb[k], bound) << known.name << " " << step;
        }
}

Reading read(const std::string& bytes) { return read_measurement(bytes); }

/// Points lie at the nodes, where the file holds the surface: f comes back to the floats of it.
TEST(SpectralRgl, HoldsTheSurfaceInTheColourOfItsSpectrum) {
    const auto surface = synthetic::ggx(0.5, {0.3, 0.3, 0.3}, {0.4, 0.4, 0.4});
    const auto plain = read(synthetic::rgl_file(surface, {}));
    for (const Known& known : kKnown) {
        const Reading reading =
            read(synthetic::rgl_file(surface, {every(358, 1002, 3.32), known.reflectance, 1}));
        EXPECT_EQ(reading.understood.format, "rgl");
        EXPECT_EQ(measured_files::finding(reading.understood, "colour"), kObserverWords);
        EXPECT_EQ(measured_files::finding(reading.understood, "convention"), "f cos theta_o");
        const Cloud& cloud = reading.components[0].cloud;
        ASSERT_EQ(cloud.size(), plain.components[0].cloud.size());
        std::size_t looked = 0;
        for (std::size_t n = 0; n < cloud.size(); ++n) {
            if (!usable(cloud.state[n]) || cloud.theta_o[n] > 80) continue;
            const double turn = cloud.phi_o[n] - cloud.phi_i[n];
            const double f =
                surface(synthetic::cosines(cloud.theta_i[n], cloud.theta_o[n], turn))[0];
            for (std::size_t k = 0; k < 3; ++k)
                ASSERT_NEAR(cloud.at(n)[k] / f, known.srgb[k], 0.002) << known.name << " " << n;
            ++looked;
        }
        EXPECT_GT(looked, 1000u);
    }
}

void expect_refused(const std::string& bytes, const std::string& words) {
    try {
        read(bytes);
        FAIL() << words;
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
    }
}

TEST(SpectralRgl, SaysWhatASpectrumLacks) {
    const auto surface = synthetic::lambert({0.5, 0.5, 0.5});
    const auto grey = [](double) { return 1.0; };
    expect_refused(synthetic::rgl_file(surface, {every(450, 1000, 10), grey, 1}),
                   "spectra from 450 to 1000 nm; a colour needs 400 to 700");
    expect_refused(synthetic::rgl_file(surface, {every(380, 720, 30), grey, 1}),
                   "no spectrum between 380 and 410 nm");
    expect_refused(synthetic::rgl_file(surface, {{400, 500, 500, 700}, grey, 1}),
                   "wavelengths do not rise");
}

TEST(Rgl, RefusesAnisotropicFilesAndSaysWhy) {
    expect_refused(synthetic::rgl_file(synthetic::lambert({0.5, 0.5, 0.5}), {{}, nullptr, 4}),
                   "an anisotropic tensor file (4 azimuths of the light)");
}

}  // namespace
}  // namespace kiln
