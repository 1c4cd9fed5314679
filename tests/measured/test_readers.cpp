// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>

#include "server/base/error.h"
#include "server/measured/bounds.h"
#include "server/measured/survey.h"
#include "tests/measured/fuzz_targets.h"
#include "tests/measured/synthetic.h"

namespace kiln {
namespace {

using namespace measured;
using namespace synthetic;

const Material kGloss = ggx(0.2, {0.9, 0.6, 0.3}, {0.1, 0.2, 0.3});

std::string refusal(const std::string& bytes, const std::string& code = "malformed_measurement") {
    try {
        read_measurement(bytes);
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), code) << error.what();
        return error.what();
    }
    ADD_FAILURE() << "was read";
    return {};
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
}

/// Each point of a cloud against the material at the cloud's own angles. Angles are floats of
/// degrees, off by up to 1.5e-5 / 2 (half a unit in the last place of 256): 1.3e-7 rad. Up to 85
/// degrees these tilt the half vector by up to 1 / (2 cos 85) = 5.7 times as much, and the
/// logarithm of GGX at alpha = .2 changes by at most 2 / alpha = 10 a radian of tilt: 7.6e-6,
/// beside 6e-8 of a float.
void expect_material(const Cloud& cloud, const Material& material, double tolerance,
                     std::size_t stride = 1) {
    std::size_t looked_at = 0;
    for (std::size_t n = 0; n < cloud.size(); n += stride) {
        if (!usable(cloud.state[n]) || cloud.theta_i[n] > 85 || cloud.theta_o[n] > 85) continue;
        const Cosines c = cosines(cloud.theta_i[n], cloud.theta_o[n],
                                  static_cast<double>(cloud.phi_o[n]) - cloud.phi_i[n]);
        const auto truth = material(c);
        for (std::size_t k = 0; k < 3; ++k)
            ASSERT_NEAR(cloud.at(n)[k], truth[k], tolerance * truth[k])
                << n << ": " << cloud.theta_i[n] << " " << cloud.theta_o[n] << " "
                << cloud.phi_o[n];
        ++looked_at;
    }
    EXPECT_GT(looked_at, cloud.size() / stride / 4);
}

TEST(Merl, GivesBackWhatWasWritten) {
    const Reading reading = read_measurement(merl_file(kGloss));
    EXPECT_EQ(reading.understood.format, "merl");
    const Component& part = reading.components[0];
    EXPECT_EQ(part.cloud.size(), 1458000u);
    expect_material(part.cloud, kGloss, 1e-5, 7);
}

TEST(Merl, LambertHasItsAlbedoAtEveryIncidence) {
    const ComponentSurvey part =
        survey(read_measurement(merl_file(lambert({0.18, 0.5, 0.9}))).components[0]);
    ASSERT_EQ(part.incidences.size(), usual_theta_in().size());
    for (const IncidenceSurvey& one : part.incidences) {
        EXPECT_GT(one.coverage, 0.99);
        // f is constant, so the integral is its share of the hemisphere, to the float's rounding.
        EXPECT_NEAR(one.albedo[0], 0.18 * one.coverage, 1e-6);
        EXPECT_NEAR(one.albedo[1], 0.5 * one.coverage, 1e-6);
        EXPECT_NEAR(one.albedo[2], 0.9 * one.coverage, 1e-6);
    }
}

TEST(Merl, ReadsTheWholeTurnOfPqba) {
    const Reading reading = read_measurement(merl_file(kGloss, 360));
    EXPECT_EQ(reading.components[0].cloud.size(), 2916000u);
    expect_material(reading.components[0].cloud, kGloss, 1e-5, 37);
}

TEST(Merl, RefusesSizesAndValuesThatAreWrong) {
    std::string bytes = merl_file(lambert({0.5, 0.5, 0.5}));
    EXPECT_EQ(refusal(bytes.substr(0, bytes.size() - 1)).substr(0, 14), "byte 34992011:");
    std::string negative = bytes;
    const std::array<std::int32_t, 3> dims = {-90, -90, 180};
    std::memcpy(negative.data(), dims.data(), 12);
    EXPECT_NE(refusal(negative).find("-90, -90, 180"), std::string::npos);
    const double infinite = INFINITY;
    std::memcpy(bytes.data() + 12 + 8 * 777, &infinite, 8);
    EXPECT_EQ(refusal(bytes).substr(0, 10), "byte 6228:");
}

TEST(Merl, NegativeInOneChannelIsNotMeasured) {
    std::string bytes = merl_file(kGloss);
    const std::size_t cell = 90 * 180 * 3 + 180 * 5 + 17;
    const double marker = -1;
    std::memcpy(bytes.data() + 12 + 8 * (1458000 + cell), &marker, 8);  // green alone
    const Reading reading = read_measurement(bytes);
    EXPECT_EQ(reading.components[0].cloud.state[cell], PointState::kNotMeasured);
    EXPECT_EQ(reading.components[0].cloud.state[cell + 1], PointState::kMeasured);
}

TEST(LightTools, GivesBackWhatWasWritten) {
    const Reading reading = read_measurement(minidiff_file(kGloss));
    EXPECT_EQ(reading.understood.format, "lighttools");
    const Cloud& cloud = reading.components[0].cloud;
    EXPECT_EQ(cloud.size(), 4u * 361 * 76);
    // Seven digits are written: 5e-7, and the float's rounding.
    expect_material(cloud, kGloss, 6e-7);
}

TEST(LightTools, TakesOtherAzimuthsOfTheLightFromTheLobe) {
    MiniDiffGrid grid;
    grid.light_azimuth = 0;
    grid.azimuth_step = 2;
    const Reading reading = read_measurement(minidiff_file(kGloss, grid));
    EXPECT_FLOAT_EQ(reading.components[0].cloud.phi_i[0], 0);
    EXPECT_FALSE(reading.understood.warnings.empty());
    ReadOptions word;
    word.phi_in_deg = 45.0;
    const Reading told = read_measurement(minidiff_file(kGloss, grid), word);
    EXPECT_FLOAT_EQ(told.components[0].cloud.phi_i[0], 45);
}

TEST(LightTools, ForgetsWhatAMiniDiffCannotReach) {
    MiniDiffGrid grid;
    grid.azimuth_step = 10;
    grid.radial_step = 5;
    grid.radial_max = 85;
    grid.model = "MiniDiff sample";
    const Reading mini = read_measurement(minidiff_file(kGloss, grid));
    EXPECT_NEAR(survey(mini.components[0]).theta_out_max, 75, 1e-5);
    grid.model = "other";
    const Reading other = read_measurement(minidiff_file(kGloss, grid));
    EXPECT_NEAR(survey(other.components[0]).theta_out_max, 85, 1e-5);
}

TEST(LightTools, NamesTheLineThatIsWrong) {
    const std::string text = small_file("lighttools");
    EXPECT_NE(refusal(replaced(text, "POI 0", "POI x")).find("line 1"), std::string::npos);
    EXPECT_NE(refusal(replaced(text, "Side Front", "Colour 5")).find("\"Colour\" is no key"),
              std::string::npos);
    // A second block of the same incidence and wavelength.
    EXPECT_NE(refusal(replaced(text, "AOI 60", "AOI 0")).find("the same block as at line"),
              std::string::npos);
}

TEST(Text, LineEndsMarksAndDecimalCommasMakeNoDifference) {
    const std::string plain = small_file("zemax");
    const Cloud expected = read_measurement(plain).components[0].cloud;
    const auto same = [&](const std::string& text) {
        const Cloud cloud = read_measurement(text).components[0].cloud;
        EXPECT_EQ(cloud.values, expected.values);
        EXPECT_EQ(cloud.theta_o, expected.theta_o);
        EXPECT_EQ(cloud.state, expected.state);
    };
    std::string cr = plain, crlf;
    std::replace(cr.begin(), cr.end(), '\n', '\r');
    for (const char c : plain) crlf += c == '\n' ? std::string("\r\n") : std::string(1, c);
    same(cr);
    same(crlf);
    same("\xef\xbb\xbf" + plain);
    same(replaced(plain, "3e-2\t2e-2\t1e-2", "0,03\t0,02\t0,01 \t "));
    same(replaced(plain, "DataEnd", "\xb5 no comment").substr(0, plain.find("DataEnd")));
}

TEST(Text, NumbersThatAreNoneAreRefusedWithTheirPlace) {
    const std::string text = small_file("zemax");
    for (const char* bad : {"nan", "inf", "1e999", "0x10", "3e-2x"}) {
        const std::string what = refusal(replaced(text, "5e-2", bad));
        EXPECT_NE(what.find("line 22: field 1"), std::string::npos) << what;
    }
    EXPECT_NE(refusal(replaced(text, "ScatterRadial\t3", "ScatterRadial\t4")).find("line 15"),
              std::string::npos);
    EXPECT_NE(refusal(replaced(text, "ScatterRadial\t3", "ScatterRadial\t1e9")).find("count"),
              std::string::npos);
}

TEST(Zemax, PutsRadialAnglesAboutTheMirrorDirection) {
    const Cloud cloud = read_measurement(small_file("zemax")).components[0].cloud;
    // Incidence 10: radial 0 is the mirror direction, radial 20 at azimuth 0 lies beyond the
    // normal, on the light's side; at azimuth 180 it lies further out.
    EXPECT_NEAR(cloud.theta_o[0], 10, 1e-4);
    EXPECT_NEAR(cloud.phi_o[0], 180, 1e-4);
    EXPECT_NEAR(cloud.theta_o[1], 10, 1e-4);
    EXPECT_NEAR(std::remainder(cloud.phi_o[1], 360.0), 0, 1e-3);
    EXPECT_NEAR(cloud.theta_o[7], 30, 1e-4);
    // 50 + 60 degrees is below the horizon, whatever the value; a zero above it is no value.
    EXPECT_EQ(cloud.state[8], PointState::kNotMeasured);
    EXPECT_EQ(cloud.state[17], PointState::kBelowHorizon);
}

TEST(Fred, ReadsSinesAndLogarithms) {
    const double s = std::sin(40 * kDegree), a = 30 * kDegree;
    char row[80];
    std::snprintf(row, sizeof row, "%.9g %.9g -2\n", std::sin(a) * s, std::cos(a) * s);
    const std::string text = std::string("type bsdf_data\nformat angles=sin bsdf=log scale=2\n") +
                             "0 0.5\n0 0 -1\n" + row;
    const Cloud cloud = read_measurement(text).components[0].cloud;
    EXPECT_NEAR(cloud.theta_i[0], 30, 1e-5);  // beta = sin 30 at phi = 0
    EXPECT_NEAR(cloud.phi_i[0], 180, 1e-5);
    EXPECT_NEAR(cloud.values[0], 0.2, 1e-7);
    EXPECT_NEAR(cloud.theta_o[1], 40, 1e-5);
    EXPECT_NEAR(cloud.phi_o[1], 30, 1e-4);
    EXPECT_NEAR(cloud.values[1], 0.02, 1e-8);
}

TEST(Astm, ReadsRadiansAndKeepsNegatives) {
    const Reading reading = read_measurement(small_file("astm"));
    const Cloud& cloud = reading.components[0].cloud;
    EXPECT_NEAR(cloud.theta_i[0], 0.5 / kDegree, 1e-4);
    EXPECT_FLOAT_EQ(cloud.at(2)[2], -0.01f);
    // Three views off the plane of incidence on one side of it: mirrored.
    EXPECT_EQ(cloud.size(), 8u);
    EXPECT_EQ(cloud.state[5], PointState::kMirrored);
}

TEST(Csv, TakesUnitsFromTheNames) {
    const std::string text =
        "theta_in_rad;phi_in_rad;theta_out_rad;phi_out_rad;brf\n0,5;0;0,25;1,5;0,9\n";
    const Reading reading = read_measurement(text);
    const Cloud& cloud = reading.components[0].cloud;
    EXPECT_NEAR(cloud.theta_o[0], 0.25 / kDegree, 1e-5);
    EXPECT_NEAR(cloud.values[0], 0.9 / std::numbers::pi, 1e-7);
    EXPECT_NE(refusal(small_file("csv") + "1,2,3\n").find("line 6: 3 numbers under 7 names"),
              std::string::npos);
}

TEST(BirdJson, RefusesWhatNoFloatHoldsByItsRange) {
    const std::string bird = small_file("bird_json");
    const std::size_t value = bird.find('[', bird.find("\"BRDF\"")) + 1;
    const std::string huge =
        bird.substr(0, value) + "1e39" + bird.substr(bird.find_first_of(",]", value));
    EXPECT_NE(refusal(huge).find("exceeds the range of float, 3.4e38"), std::string::npos)
        << refusal(huge);
}

TEST(BirdJson, RefusesArraysOfUnequalLength) {
    EXPECT_NE(refusal(replaced(small_file("bird_json"), "[10,20,10,20]", "[10,20,10]"))
                  .find("/data/theta_r/values"),
              std::string::npos);
}

TEST(Readers, RecogniseTheirOwnAndNoOther) {
    for (const Reader& reader : readers()) {
        const std::string bytes = small_file(reader.name);
        for (const Reader& other : readers())
            EXPECT_EQ(other.recognises(bytes), other.name == reader.name)
                << other.name << " on a file of " << reader.name;
        if (reader.name != "merl") {
            EXPECT_EQ(read_measurement(bytes).understood.format, reader.name);
        }
    }
    EXPECT_NE(refusal("hello", "unknown_measurement").find("MERL"), std::string::npos);
}

TEST(Readers, ExcelIsRefusedForAReason) {
    EXPECT_NE(refusal("\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1", "unreadable_measurement").find("CSV"),
              std::string::npos);
}

TEST(Readers, NothingAndOtherJsonAreCalledThat) {
    EXPECT_EQ(refusal("", "unreadable_measurement"), "the file is empty");
    const std::string bird = small_file("bird_json");
    for (const std::string& text : {bird.substr(0, bird.find("theta_i")), std::string(" {}")})
        EXPECT_NE(refusal(text, "unreadable_measurement").find("this begins as JSON"),
                  std::string::npos);
}

TEST(Readers, SizeBombsAreRefusedBeforeTheyExpand) {
    std::string tags = "<WindowElement>";
    for (int n = 0; n < 210000; ++n) tags += "<a/>";
    refusal(tags, "measurement_too_large");
    std::string deep = R"({"theta_i":0,"BRDF":)" + std::string(100000, '[');
    EXPECT_FALSE(refusal(deep).empty());
    refusal(std::string(kFileBytesMax + 1, ' '), "measurement_too_large");
}

/// Whatever a file is: its account says how values, units, azimuths, symmetry and masks were
/// understood, and what speaks for each.
TEST(Readers, AllSayWhatTheyUnderstoodAndWhy) {
    for (const FuzzTarget& target : fuzz_targets()) {
        const Reading reading =  // MERL's is of a small table, which the format has not
            target.name == "merl" ? target.read(target.seed) : read_measurement(target.seed);
        for (const char* what : {"convention", "units", "azimuth", "symmetry", "mask"}) {
            const std::vector<Finding>& all = reading.understood.findings;
            const auto one = std::find_if(all.begin(), all.end(),
                                          [what](const Finding& f) { return f.what == what; });
            ASSERT_NE(one, all.end()) << target.name << " " << what;
            EXPECT_FALSE(one->value.empty() || one->evidence.empty()) << target.name << " " << what;
        }
    }
}

/// A mask of one bit alone is of no polarity, and no direction is lost by it.
TEST(Rgl, AMaskOfOneBitTellsNothing) {
    const auto read = [](std::optional<char> mask) {
        RglLayout layout;
        layout.mask = mask;
        return read_measurement(rgl_file(kGloss, layout));
    };
    const auto mask_of = [](const Reading& reading) {
        const std::vector<Finding>& all = reading.understood.findings;
        return *std::find_if(all.begin(), all.end(),
                             [](const Finding& one) { return one.what == "mask"; });
    };
    const Reading known = read({});
    EXPECT_EQ(mask_of(known).value, "bit 1 is above the horizon");
    for (const auto& [byte, share] : {std::pair('\0', "0"), std::pair('\xff', "100")}) {
        const Reading reading = read(byte);
        EXPECT_EQ(mask_of(reading).value, "the bits tell nothing of the horizon");
        EXPECT_NE(mask_of(reading).evidence.find(std::string("set in ") + share +
                                                 " % of the places "
                                                 "above and in " +
                                                 share + " % of those below"),
                  std::string::npos)
            << mask_of(reading).evidence;
        EXPECT_EQ(reading.components[0].cloud.state, known.components[0].cloud.state);
    }
}

}  // namespace
}  // namespace kiln
