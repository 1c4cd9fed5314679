// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "server/image/image.h"
#include "server/spec/words.h"
#include "tests/image/own_readers.h"
#include "tests/image/tables.h"

namespace {

using namespace kiln;

const Metadata kSome = {{"kiln.job", R"({"a":1})"}, {"kiln.axes", "x: one\ny: two"}};

Encoded png(const Table& table, PixelType pixel) {
    return encode(table, ImageFormat::png, pixel, kSome);
}

unsigned code_max(PixelType pixel) { return pixel == PixelType::uint8 ? 255 : 65535; }

std::vector<std::string> data_of(const own::Png& file, const std::string& type) {
    std::vector<std::string> all;
    for (const auto& [chunk, data] : file.chunks)
        if (chunk == type) all.push_back(data);
    return all;
}

struct Shape {
    std::size_t width, height, channels;
    PixelType pixel;
};

void PrintTo(const Shape& shape, std::ostream* out) {
    *out << shape.width << " x " << shape.height << " x " << shape.channels << ' '
         << to_word(shape.pixel);
}

class PngShapes : public testing::TestWithParam<Shape> {};

TEST_P(PngShapes, EveryCodeIsTheNearest) {
    const auto [width, height, channels, pixel] = GetParam();
    const unsigned top = code_max(pixel);
    // Each value is built from the code that it must get, up to 0.45 of a step aside: float's
    // rounding moves it by 2^-25 * 65535 = 0.002 steps at most, so that no other code is nearest.
    const auto wanted = [&](std::size_t c, std::size_t i) {
        return static_cast<unsigned>((i * 2654435761U + c * 40503U + 7) % (top + 1));
    };
    const Table table = tables::filled(width, height, channels, [&](std::size_t c, std::size_t i) {
        const unsigned code = wanted(c, i);
        const double aside = code == 0 || code == top ? 0.0 : (i % 2 == 0 ? 0.45 : -0.45);
        return static_cast<float>((code + aside) / top);
    });
    const Encoded encoded = png(table, pixel);
    const own::Png file = own::read_png(encoded.bytes);
    const Decoded decoded = decode(encoded.bytes);

    EXPECT_EQ(encoded.extension, "png");
    ASSERT_EQ(file.width, width);
    ASSERT_EQ(file.height, height);
    EXPECT_EQ(file.bit_depth, pixel == PixelType::uint8 ? 8 : 16);
    EXPECT_EQ(file.colour_type, channels == 1 ? 0 : channels == 4 ? 6 : 2);
    EXPECT_EQ(file.interlace, 0);
    const std::size_t stored = channels == 2 ? 3 : channels;
    ASSERT_EQ(file.codes.size(), width * height * stored);
    ASSERT_EQ(decoded.table.planes.size(), stored);
    for (std::size_t c = 0; c < stored; ++c) {
        double worst = 0;
        for (std::size_t i = 0; i < width * height; ++i) {
            const unsigned code = file.codes[i * stored + c];
            ASSERT_EQ(code, c < channels ? wanted(c, i) : 0U) << "channel " << c << " texel " << i;
            // Read back normalised, correct to float's rounding (2^-25 relative to at most 1).
            ASSERT_NEAR(decoded.table.planes[c][i], double(code) / top, 0x1p-25);
            if (c < channels)
                worst = std::max(worst, std::abs(double(code) / top - double(table.planes[c][i])));
        }
        if (c == channels) break;
        EXPECT_DOUBLE_EQ(encoded.quantisation_max.at(c), worst);
        EXPECT_LE(worst, 0.5 / top);
        EXPECT_EQ(encoded.clamped.at(c), 0U);
    }
}

INSTANTIATE_TEST_SUITE_P(
    Shapes, PngShapes,
    testing::Values(Shape{1, 1, 1, PixelType::uint8}, Shape{1, 1, 4, PixelType::uint16},
                    Shape{17, 16, 1, PixelType::uint8}, Shape{17, 16, 2, PixelType::uint8},
                    Shape{17, 16, 3, PixelType::uint8}, Shape{17, 16, 4, PixelType::uint8},
                    Shape{64, 33, 1, PixelType::uint16}, Shape{64, 33, 2, PixelType::uint16},
                    Shape{64, 33, 3, PixelType::uint16}, Shape{64, 33, 4, PixelType::uint16},
                    Shape{4096, 1, 2, PixelType::uint16}, Shape{1, 4096, 1, PixelType::uint8}));

TEST(Png, ValuesOutsideTheUnitIntervalAreClampedAndCountedByChannel) {
    const std::vector<float> first = {-0.1F, 0.0F, 1.0F, std::nextafter(1.0F, 2.0F), 0.2F, -0.0F};
    const std::vector<float> second = {0.2F, 0.4F, 0.6F, 0.8F, 1e30F, 1.0F};
    const Table table = tables::filled(
        6, 1, 2, [&](std::size_t c, std::size_t i) { return c == 0 ? first[i] : second[i]; });
    const Encoded encoded = png(table, PixelType::uint8);
    EXPECT_EQ(encoded.clamped, (std::vector<std::uint64_t>{2, 1}));
    const own::Png file = own::read_png(encoded.bytes);
    const std::vector<unsigned> expected = {0,   51,  0, 0,  102, 0, 255, 153, 0,
                                            255, 204, 0, 51, 255, 0, 0,   255, 0};
    EXPECT_EQ(file.codes, expected);
    // 0.2 … 0.8 are multiples of 51/255, so that only float's rounding of them is left.
    for (const double q : encoded.quantisation_max) EXPECT_LE(q, 0x1p-25);
}

TEST(Png, MarksItselfLinearAndHoldsNothingOfTimeOrPlace) {
    const own::Png file = own::read_png(png(tables::noise(9, 4, 3, 0, 1), PixelType::uint16).bytes);
    for (const auto& [type, data] : file.chunks)
        EXPECT_TRUE(type == "IHDR" || type == "gAMA" || type == "tEXt" || type == "IDAT" ||
                    type == "IEND")
            << type;
    EXPECT_EQ(data_of(file, "gAMA"), std::vector<std::string>{std::string("\x00\x01\x86\xa0", 4)});
    EXPECT_EQ(data_of(file, "tEXt"),
              (std::vector<std::string>{std::string("kiln.job\0{\"a\":1}", 16),
                                        std::string("kiln.axes\0x: one\ny: two", 23)}));
}

TEST(Png, TwoChannelsSayThatBlueIsEmpty) {
    const Decoded decoded = decode(png(tables::noise(3, 3, 2, 0, 1), PixelType::uint8).bytes);
    Metadata expected = kSome;
    expected.emplace_back("kiln.unused_channel", "B is 0 and carries no quantity");
    EXPECT_EQ(decoded.metadata, expected);
    EXPECT_EQ(decoded.table.channels, (std::vector<std::string>{"R", "G", "B"}));
}

TEST(Png, EqualTablesGiveEqualBytes) {
    const Table table = tables::noise(64, 64, 3, 0, 1);
    for (const PixelType pixel : {PixelType::uint8, PixelType::uint16})
        EXPECT_EQ(png(table, pixel).bytes, png(table, pixel).bytes);
}

TEST(Png, FiveChannelsAndFloatingPointAreRefused) {
    EXPECT_EQ(tables::code_of([] { png(tables::noise(2, 2, 5, 0, 1), PixelType::uint8); }),
              "cannot_encode");
    for (const PixelType pixel : {PixelType::half, PixelType::float32})
        EXPECT_EQ(tables::code_of([&] { png(tables::noise(2, 2, 1, 0, 1), pixel); }),
                  "cannot_encode");
}

}  // namespace
