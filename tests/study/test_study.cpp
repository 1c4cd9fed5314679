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
        LineChart{"Lines", "x", "y", true, false, {{"s", {1, 10}, {0, 1}, {}, {}}}, 0.5},
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
    EXPECT_EQ(std::get<LineChart>(back->charts[0]).level, 0.5);
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

/// Rows of a picture of one chart in which `is` holds for four of five pixels across the plot.
template <class Is>
int rows_where(const LineChart& chart, Is is) {
    Study study = sample();
    study.charts = {chart};
    const Table picture = decode(draw_png(study)).table;
    constexpr std::size_t kLeft = 2 * (24 + 62) + 4, kRight = 2 * (24 + 560 - 12) - 4;
    int rows = 0;
    for (std::size_t y = 0; y < picture.height; ++y) {
        std::size_t count = 0;
        for (std::size_t x = kLeft; x < kRight; ++x)
            count += is(picture.planes[0][y * picture.width + x],
                        picture.planes[2][y * picture.width + x]);
        rows += 5 * count > 4 * (kRight - kLeft);
    }
    return rows;
}

// Dark from one side of the frame to the other, as its two ends are.
TEST(Study, ALevelIsALineAcrossTheChart) {
    LineChart chart{"Lines", "x", "y", false, false, {{"s", {0, 1}, {1, 2}, {}, {}}}};
    const auto dark = [](double red, double blue) { return red < 0.5 && blue < 0.5; };
    const int frame = rows_where(chart, dark);
    EXPECT_GE(frame, 2);
    chart.level = 1.5;
    EXPECT_GE(rows_where(chart, dark), frame + 2);  // 1.4 points are 2.8 pixels
    // Not a value of the curves, nor within them: the axis goes as far.
    chart.level = 4;
    EXPECT_GE(rows_where(chart, dark), frame + 2);
}

// 1 and the next float: a straight line, not one from corner to corner.
TEST(Study, RoundingFillsNoChart) {
    const auto is_blue = [](double red, double blue) { return red < 0.5 && blue > 0.6; };
    LineChart chart{"Lines", "x", "y", false, false, {{"s", {}, {}, {}, {}}}};
    for (int i = 0; i <= 20; ++i) {
        chart.series[0].x.push_back(i);
        chart.series[0].y.push_back(i % 2 ? 1 + 0x1p-23 : 1);
    }
    EXPECT_GE(rows_where(chart, is_blue), 2);
}

TEST(Study, SvgIsAPictureOfTheSameShape) {
    const std::string svg = draw_svg(sample());
    EXPECT_NE(svg.find("<svg"), std::string::npos);
    const Decoded png = decode(draw_png(sample()));
    EXPECT_NE(svg.find("width=\"" + std::to_string(png.table.width / 2)), std::string::npos);
}

}  // namespace
}  // namespace kiln
