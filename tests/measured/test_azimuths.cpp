// SPDX-License-Identifier: Apache-2.0
// Surfaces that turn: known ones in RGL's layout and as columns, under single azimuths of the light
// and under all.
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "server/base/error.h"
#include "server/measured/slices.h"
#include "tests/measured/files.h"
#include "tests/measured/synthetic.h"

namespace kiln {
namespace {

using namespace measured;
using measured_files::finding;
using measured_files::material_of;

const synthetic::Brushed kBrushed;

std::vector<double> every(double from, double to, double step) {
    std::vector<double> list;
    for (double at = from; at <= to + 1e-9; at += step) list.push_back(at);
    return list;
}

std::string file_of(std::vector<double> phi_in, std::size_t nodes = 49) {
    return synthetic::rgl_file(kBrushed, {{}, nullptr, nodes, std::move(phi_in), {}});
}

/// A file of a quadrant, in steps of 15 degrees.
const std::string& quadrant() {
    static const std::string file = file_of(every(-180, -90, 15));
    return file;
}

/// Mean |f - truth| cos relative to the mean of truth cos, views to 73 degrees in the frame of the
/// light.
double relative_error(const std::function<double(Vec)>& f,
                      const std::function<double(double, double)>& truth) {
    double off = 0, all = 0;
    for (double theta = 1.3; theta < 73; theta += 2.3)
        for (double phi = 0.7; phi < 360; phi += 7.3) {
            const double weight = std::sin(2 * theta * kDegree), t = truth(theta, phi);
            off += weight * std::abs(f(direction(theta, phi)) - t);
            all += weight * t;
        }
    return off / all;
}

std::function<double(double, double)> truth_at(double theta_in, double phi_in) {
    return
        [=](double theta, double phi) { return kBrushed(theta_in, phi_in, theta, phi_in + phi); };
}

std::function<double(double, double)> mean_truth(double theta_in) {
    return [=](double theta, double phi) {
        double sum = 0;
        for (int turn = 0; turn < 360; turn += 3)
            sum += kBrushed(theta_in, turn, theta, turn + phi);
        return sum / 120;
    };
}

/// What a quadrant, half a turn and a whole one hold are the file's own values, at its own nodes.
TEST(AnisotropicRgl, HoldsTheSurfaceUnderEachAzimuth) {
    const struct {
        std::vector<double> phi_in;
        const char* symmetry;
        std::size_t azimuths;
    } kinds[] = {{every(-180, -90, 30), "anisotropic, mirrored in x and y", 4},
                 {every(-180, 0, 45), "anisotropic, a half turn changes nothing", 5},
                 {every(-180, 180, 60), "anisotropic", 6}};
    for (const auto& kind : kinds) {
        const Reading reading = read_measurement(file_of(kind.phi_in, 33));
        EXPECT_EQ(finding(reading.understood, "symmetry"), kind.symmetry);
        EXPECT_EQ(finding(reading.understood, "convention"), "f cos theta_o");
        EXPECT_EQ(finding(reading.understood, "mask"), "bit 1 is above the horizon");
        const Cloud& cloud = reading.components[0].cloud;
        std::set<float> azimuths(cloud.phi_i.begin(), cloud.phi_i.end());
        EXPECT_EQ(azimuths.size(), kind.azimuths);
        for (std::size_t n = 0; n < cloud.size(); ++n) {
            if (!usable(cloud.state[n]) || cloud.theta_o[n] > 80) continue;
            const double f =
                kBrushed(cloud.theta_i[n], cloud.phi_i[n], cloud.theta_o[n], cloud.phi_o[n]);
            ASSERT_NEAR(cloud.at(n)[0] / f, 1, 1e-3) << kind.symmetry << " " << n;
        }
    }
}

/// Light and view change places under two azimuths of the light; as an isotropic file, which this
/// is not, the same values would be far off.
TEST(AnisotropicRgl, IsReciprocalUnderItsAzimuthsAlone) {
    const Reading reading = read_measurement(file_of(every(-180, 180, 20), 33));
    const ReciprocityError own = survey(reading.components[0]).reciprocity;
    EXPECT_GT(own.pairs, 2000u);
    EXPECT_LT(own.median, 0.005);
    Component one = reading.components[0];
    Cloud& cloud = one.cloud;
    for (std::size_t n = 0; n < cloud.size(); ++n)
        if (std::abs(cloud.phi_i[n] - 180) > 1) cloud.state[n] = PointState::kBelowHorizon;
    EXPECT_GT(survey(one).reciprocity.median, 0.1);
}

TEST(AnisotropicRgl, RefusesAzimuthsThatLeaveOutATurn) {
    for (const auto& phi_in : {every(-180, -100, 20), every(-170, -80, 30)}) try {
            read_measurement(file_of(phi_in, 9));
            FAIL();
        } catch (const Error& error) {
            EXPECT_EQ(error.code(), "unreadable_measurement");
            EXPECT_NE(std::string(error.what()).find("a whole turn, a half one or a quadrant"),
                      std::string::npos)
                << error.what();
        }
}

SliceLayout small_layout() {
    SliceLayout layout;
    layout.width = 181;
    layout.height = 91;
    return layout;
}

/// Under one of the file's azimuths, and its image in the fourth quadrant.
TEST(AnisotropicRgl, IsTheSurfaceWhereItWasMeasuredAndWhereMirrorsShowIt) {
    for (const double phi_in : {180.0, 285.0}) {
        const Material material = material_of(quadrant(), {}, phi_in);
        EXPECT_EQ(material.azimuths().measured, 7u);
        EXPECT_GT(material.azimuths().spread, 0.1);
        EXPECT_EQ(material.azimuths().error, 0);
        Origin origin{};
        for (const double theta_in : {0.0, 20.0, 35.0, 60.0})
            EXPECT_LT(
                relative_error([&](Vec out) { return material.value(theta_in, out, origin)[1]; },
                               truth_at(theta_in, phi_in)),
                0.01)
                << phi_in << " " << theta_in;
    }
}

/// The whole chain in the middle of two azimuths, and of all of them. Of points at half vectors the
/// prediction is up to five times the truth, never below it by more than a half.
TEST(AnisotropicRgl, TheWholeChainIsWithinTwoPercent) {
    const SliceLayout layout = small_layout();
    for (const PhiIn phi_in : {PhiIn(52.5), PhiIn()}) {
        const Material material = material_of(quadrant(), {}, phi_in);
        const SliceTable made = make_slices(layout, {&material});
        double sum = 0;
        int count = 0;
        for (double theta_in = 0; theta_in <= 60; theta_in += 7.5) {
            const auto shader = [&](Vec out) { return look_up(layout, made, 0, theta_in, out)[1]; };
            const double error =
                relative_error(shader, phi_in ? truth_at(theta_in, *phi_in) : mean_truth(theta_in));
            EXPECT_LT(error, 0.02) << phi_in.value_or(-1) << " " << theta_in;
            sum += error;
            ++count;
        }
        const PredictedError& predicted = made.accounts[0].predicted;
        EXPECT_EQ(predicted.azimuths, material.azimuths().error);
        EXPECT_LT(sum / count, 2 * predicted.between_incidences());
        EXPECT_GT(sum / count, 0.2 * predicted.between_incidences());
    }
}

/// Tables of two azimuths, 10 degrees apart, and a shader that goes linearly between them.
TEST(AnisotropicRgl, SeveralAzimuthsHoldTheSurfaceAsItTurns) {
    const Material first = material_of(quadrant(), {}, 30),
                   second = material_of(quadrant(), {}, 40);
    Origin origin{};
    for (const double theta_in : {20.0, 45.0, 60.0}) {
        const auto shader = [&](Vec out) {
            return 0.5 *
                   (first.value(theta_in, out, origin)[1] + second.value(theta_in, out, origin)[1]);
        };
        EXPECT_LT(relative_error(shader, truth_at(theta_in, 35)), 0.02) << theta_in;
    }
}

/// The mean over azimuths is reciprocal where f is; one azimuth of a surface that turns is not.
TEST(Azimuths, OnlyTheirMeanIsReciprocal) {
    const auto worst = [](PhiIn phi_in) {
        const Material material = material_of(quadrant(), {}, phi_in);
        double most = 0;
        for (const double a : {20.0, 40.0})
            for (const double b : {50.0, 60.0})
                for (double turn = 0; turn < 360; turn += 30) {
                    Origin origin{};
                    const double there = material.value(a, direction(b, turn), origin)[1];
                    const double back = material.value(b, direction(a, -turn), origin)[1];
                    most = std::max(most, std::abs(there / back - 1));
                }
        return most;
    };
    EXPECT_LT(worst({}), 0.03);
    EXPECT_GT(worst(30), 0.2);
}

/// Columns with phi_in are the same idea: the same tables, of steps of 5 degrees.
TEST(Azimuths, OfColumnsAreThoseOfTensorFiles) {
    const std::string file = synthetic::csv_file(kBrushed, {0, 30, 60}, every(0, 345, 15), 5);
    for (const PhiIn phi_in : {PhiIn(45), PhiIn(52.5), PhiIn()}) {
        const Material material = material_of(file, {}, phi_in);
        EXPECT_EQ(material.azimuths().measured, 24u);
        Origin origin{};
        for (const double theta_in : {0.0, 30.0, 60.0})
            EXPECT_LT(
                relative_error([&](Vec out) { return material.value(theta_in, out, origin)[1]; },
                               phi_in ? truth_at(theta_in, *phi_in) : mean_truth(theta_in)),
                0.02)
                << phi_in.value_or(-1) << " " << theta_in;
    }
}

/// Only azimuths of 90 degrees at most apart have anything between them.
TEST(Azimuths, AreNotInventedAcrossWideGaps) {
    const std::string file = synthetic::csv_file(kBrushed, {0, 40}, {0, 90}, 15);
    EXPECT_NO_THROW(material_of(file, {}, 45));
    EXPECT_NO_THROW(material_of(file, {}, 90));
    for (const double phi_in : {91.0, 200.0, 350.0}) try {
            material_of(file, {}, phi_in);
            FAIL() << phi_in;
        } catch (const Error& error) {
            EXPECT_EQ(error.code(), "unfit_measurement");
            EXPECT_NE(std::string(error.what())
                          .find("at theta_in = 40 no light was measured on "
                                "both sides of phi_in"),
                      std::string::npos)
                << error.what();
        }
}

/// Of a surface that does not turn every azimuth is the mean of all, and nobody is warned.
TEST(Azimuths, OfAnIsotropicSurfaceAreAlike) {
    const synthetic::Brushed even{0.4, 0.4, 0.5, 0.2};
    const std::string file = synthetic::csv_file(even, {0, 30, 60}, every(0, 315, 45), 5);
    Reading reading = read_measurement(file);
    const Material mean(reading.components[0], {}, reading.understood);
    EXPECT_TRUE(reading.understood.warnings.empty());
    EXPECT_LT(mean.azimuths().spread, 1e-5);
    const Material between = material_of(file, {}, 20);
    EXPECT_FALSE(between.azimuths().at_halves);  // about the mirror direction they agree wholly
    EXPECT_LT(between.azimuths().error, 1e-5);
    Origin origin{};
    for (const double theta : {10.0, 40.0, 70.0})
        for (const double phi : {0.0, 100.0, 180.0})
            EXPECT_NEAR(between.value(30, direction(theta, phi), origin)[1] /
                            mean.value(30, direction(theta, phi), origin)[1],
                        1, 0.01);
}

/// A format that knows isotropic materials says that every phi_in is alike; a file that only
/// happens to hold one azimuth does not.
TEST(Azimuths, OfAFormatThatSaysIsotropicAreAllKnown) {
    const synthetic::Brushed even{0.4, 0.4, 0.5, 0.2};
    const std::string file = synthetic::rgl_file(even, {{}, nullptr, 17, {0}, {}});
    const Material mean = material_of(file), turned = material_of(file, {}, 30);
    EXPECT_TRUE(turned.goes_on_by_reciprocity());
    Origin origin{};
    for (const double theta : {10.0, 40.0, 85.0})
        EXPECT_EQ(turned.value(theta, direction(40, 100), origin),
                  mean.value(theta, direction(40, 100), origin));
    EXPECT_THROW(material_of(synthetic::csv_file(even, {0, 30, 60}, {0}, 15), {}, 30), Error);
}

}  // namespace
}  // namespace kiln
