// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <limits>

#include "server/image/image.h"
#include "server/study/draw.h"
#include "tests/study/studying.h"

namespace kiln {
namespace {

Study sample() {
    const double nan = std::numeric_limits<double>::quiet_NaN(),
                 inf = std::numeric_limits<double>::infinity();
    Study study;
    study.title = "A title";
    study.notes = {
        "a note that is long enough to be laid on more than one line of the sheet, since "
        "it goes on and on about nothing in particular until it is longer than the "
        "paper is wide, and then some more"};
    study.verdicts = {{"energy", false, false, 1.5, 1.0, "too much"},
                      {"order", true, true, {}, inf, "fine"}};
    study.table = {{"a", "b, \"c\""}, {{1.0, std::string("x")}, {nan, {}}}};
    study.charts = {
        LineChart{"Lines", "x", "y", true, false, {{"s", {1, 10}, {0, 1}, {}, {}}}},
        HeatMap{"Heat", "x", "y", "v", {"p", "q"}, {"r"}, {nan, 1e-3}, 1e-9, 1, {false, true}},
        FurnaceBalls{"Balls", {{"one", {{{0.5, 0.25, 1.5}}}}}}};
    return study;
}

TEST(Study, SurvivesItsJson) {
    const Study study = sample();
    const auto back = study_of_report(with_study(R"({"job":"x"})", study));
    ASSERT_TRUE(back.has_value());
    EXPECT_EQ(to_json(*back), to_json(study));
    EXPECT_NE(to_json(study).find("\"inf\""), std::string::npos);
    EXPECT_TRUE(std::isnan(std::get<HeatMap>(back->charts[1]).values[0]));
    EXPECT_TRUE(std::isnan(back->table.rows[1][0].number.value()));
    EXPECT_FALSE(back->table.rows[1][1].number.has_value());
    EXPECT_FALSE(back->verdicts[1].value.has_value());
}

TEST(Study, WhatIsNoStudyIsNone) {
    for (const char* text : {"", "{}", R"({"study":1})", R"({"study":{"title":"x"}})", "[1"})
        EXPECT_FALSE(study_of_report(text).has_value()) << text;
}

// RFC 4180: quotes doubled, fields with separators quoted, lines ended by CR LF.
TEST(Study, CsvQuotesWhatHasSeparators) {
    EXPECT_EQ(to_csv(sample().table), "a,\"b, \"\"c\"\"\"\r\n1,x\r\nnan,\r\n");
}

// The ball of one value alone: the middle of its square is that value, half as bright, in sRGB.
TEST(Study, BallsShowTheirValues) {
    Study study = sample();
    study.charts = {study.charts[2]};
    const Table picture = decode(draw_png(study)).table;
    ASSERT_EQ(picture.planes.size(), 3u);
    const std::size_t x = 2 * (24 + 12 + 75), y = 2 * (58 + 30 + 75);
    const double expected[] = {0.25, 0.125, 0.75};
    for (std::size_t c = 0; c < 3; ++c) {
        const double linear = expected[c];
        const double encoded = 1.055 * std::pow(linear, 1 / 2.4) - 0.055;  // IEC 61966-2-1
        EXPECT_NEAR(picture.planes[c][y * picture.width + x], encoded, 1.0 / 255);
    }
    // The surroundings are the furnace itself.
    const std::size_t corner = (y - 145) * picture.width + x - 145;
    EXPECT_NEAR(picture.planes[0][corner], 1.055 * std::pow(0.5, 1 / 2.4) - 0.055, 1.0 / 255);
}

TEST(Study, SvgIsAPictureOfTheSameShape) {
    const std::string svg = draw_svg(sample());
    EXPECT_NE(svg.find("<svg"), std::string::npos);
    const Decoded png = decode(draw_png(sample()));
    EXPECT_NE(svg.find("width=\"" + std::to_string(png.table.width / 2)), std::string::npos);
}

}  // namespace
}  // namespace kiln
