// SPDX-License-Identifier: Apache-2.0
// Spectral tensor files: the colour of known reflectances, and the shape of a known surface.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <functional>
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

Rgb seen(const std::vector<double>& nm, const std::function<double(double)>& reflectance) {
    const auto weights = srgb_weights(nm);
    Rgb sum{};
    for (std::size_t n = 0; n < nm.size(); ++n)
        for (std::size_t k = 0; k < 3; ++k) sum[k] += weights[n][k] * reflectance(nm[n]);
    return sum;
}

/// Why the bound of steps is what it is: edges anywhere, steps from anywhere. Lines between samples
/// cut curvature, which goes with the square of the step.
TEST(Observer, StepsOf25NanometresAreEnough) {
    double wide = 0, lamps = 0;
    for (double at = 420; at <= 660; at += 20) {
        const auto reflectance = [at](double nm) { return edge(nm, at); };
        const Rgb truth = seen(every(360, 830, 1), reflectance);
        for (double start = 376; start <= 400; start += 8) {
            const std::vector<double> nm = every(start, 725, 25);
            EXPECT_EQ(lacks_for_colour(nm), "");
            const Rgb found = seen(nm, reflectance);
            const Rgb coarse = seen(every(start, 760, 50), reflectance);
            for (std::size_t k = 0; k < 3; ++k) {
                EXPECT_NEAR(found[k], truth[k], 0.02) << at << " " << start;
                wide = std::max(wide, std::abs(coarse[k] - truth[k]));
            }
        }
        const Rgb single = {edge(620, at), edge(540, at), edge(460, at)};
        for (std::size_t k = 0; k < 3; ++k) lamps = std::max(lamps, std::abs(single[k] - truth[k]));
    }
    EXPECT_GT(wide, 0.04);
    EXPECT_GT(lamps, 0.2);
    EXPECT_NE(lacks_for_colour(every(400, 700, 26)), "");
    EXPECT_NE(lacks_for_colour(every(401, 701, 25)), "");
}

Reading read(const std::string& bytes) { return read_measurement(bytes); }

/// Points lie at the nodes, where the file holds the surface: f comes back to the floats of it.
TEST(SpectralRgl, HoldsTheSurfaceInTheColourOfItsSpectrum) {
    const auto surface = synthetic::ggx(0.5, {0.3, 0.3, 0.3}, {0.4, 0.4, 0.4});
    const auto plain = read(synthetic::rgl_file(surface, {}));
    for (const Known& known : kKnown) {
        const Reading reading =
            read(synthetic::rgl_file(surface, {every(358, 1002, 3.32), known.reflectance}));
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
    expect_refused(synthetic::rgl_file(surface, {every(450, 1000, 10), grey}),
                   "spectra from 450 to 1000 nm; a colour needs 400 to 700");
    expect_refused(synthetic::rgl_file(surface, {every(380, 720, 30), grey}),
                   "no spectrum between 380 and 410 nm");
    expect_refused(synthetic::rgl_file(surface, {{400, 500, 500, 700}, grey}),
                   "wavelengths do not rise");
}

/// A Lambertian surface of a known reflectance, in rows of directions.
std::vector<std::array<double, 4>> rows_of_directions() {
    std::vector<std::array<double, 4>> rows;
    for (const double theta_in : {0.0, 40.0})
        for (const double theta_out : {0.0, 30.0, 60.0, 80.0})
            for (double phi = 0; phi < (theta_out > 0 ? 360 : 1); phi += 45)
                rows.push_back({theta_in, 0, theta_out, phi});
    return rows;
}

std::string digits(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.7g", value);
    return text;
}

std::string columns_file(const Known& known, const std::vector<double>& nm, bool astm) {
    std::string text = astm ? "made by a test\nVARS theta_i,phi_i,theta_s,phi_s"
                            : "theta_in,phi_in,theta_out,phi_out";
    for (const double at : nm) text += "," + digits(at) + "nm";
    for (const auto& row : rows_of_directions()) {
        text += "\n";
        for (std::size_t n = 0; n < 4; ++n)
            text += (n > 0 ? "," : "") + digits(astm ? row[n] * kDegree : row[n]);
        for (const double at : nm) text += "," + digits(known.reflectance(at) / std::numbers::pi);
    }
    return text + "\n";
}

std::string bird_file(const Known& known, const std::vector<double>& nm) {
    std::array<std::string, 6> lists;  // angles, values, wavelengths
    for (const auto& row : rows_of_directions())
        for (const double at : nm) {
            const std::string comma = lists[0].empty() ? "" : ",";
            for (std::size_t n = 0; n < 4; ++n) lists[n] += comma + digits(row[n]);
            lists[4] += comma + digits(known.reflectance(at) / std::numbers::pi);
            lists[5] += comma + digits(at);
        }
    constexpr std::array<const char*, 6> kNames = {"theta_i", "phi_i", "theta_r",
                                                   "phi_r",   "BRDF",  "wavelength_i"};
    std::string text = "{\"data\":{";
    for (std::size_t n = 0; n < 6; ++n)
        text += std::string(n > 0 ? "," : "") + "\"" + kNames[n] + "\":{\"unit\":\"" +
                (n < 4    ? "deg"
                 : n == 4 ? "1/sr"
                          : "nm") +
                "\",\"values\":[" + lists[n] + "]}";
    return text + "}}";
}

/// Whatever the format: from enough wavelengths a material has the colour that the tables say, and
/// it says by whom it was seen.
TEST(Spectra, OfEveryFormatAreSeenByTheObserver) {
    const std::vector<double> nm = every(380, 730, 10);
    for (const Known& known : kKnown)
        for (const std::string& file : {columns_file(known, nm, false),
                                        columns_file(known, nm, true), bird_file(known, nm)}) {
            Reading reading = read(file);
            const std::string words = measured_files::finding(reading.understood, "colour");
            EXPECT_EQ(words,
                      std::string(kObserverWords) + ", of 36 wavelengths from 380 to 730 nm");
            const Material material(reading.components[0], {}, reading.understood);
            EXPECT_EQ(material.colour(), words);
            Origin origin{};
            const Colour f = material.value(20, direction(40, 100), origin);
            // As above: 0.0012 and the lines between samples, 10 nm apart.
            for (std::size_t k = 0; k < 3; ++k)
                EXPECT_NEAR(f[k] * std::numbers::pi, known.srgb[k], 0.0012 + 0.4 * 0.444 / 12)
                    << known.name << " " << reading.understood.format;
        }
}

/// Of wavelengths too few the nearest stand for the colours, and the account says why.
TEST(Spectra, OfFewWavelengthsAreTakenAsTheyAre) {
    const Known& red = kKnown[1];
    Reading reading = read(columns_file(red, {450, 550, 650}, false));
    const Material material(reading.components[0], {}, reading.understood);
    EXPECT_EQ(material.colour(),
              "650, 550, 450 nm as red, green and blue, as they are: spectra from 450 to 650 nm; a "
              "colour needs 400 to 700 nm");
    Origin origin{};
    const Colour f = material.value(20, direction(40, 100), origin);
    EXPECT_NEAR(f[0] * std::numbers::pi, edge(650, 590), 1e-6);
    EXPECT_NEAR(f[2] * std::numbers::pi, edge(450, 590), 1e-6);
    EXPECT_NE(measured_files::finding(
                  read(columns_file(red, every(400, 700, 50), false)).understood, "colour")
                  .find("no spectrum between 400 and 450 nm; a colour needs steps of at most 25"),
              std::string::npos);
}

}  // namespace
}  // namespace kiln
