// SPDX-License-Identifier: Apache-2.0
// Three colours in 32 bits: the bits, where each format has them, and the way back.
#include <gtest/gtest.h>

#include <cmath>

#include "server/base/error.h"
#include "server/base/rgb9e5.h"
#include "server/image/image.h"
#include "server/spec/pixel_words.h"
#include "tests/image/own_readers.h"

namespace kiln {
namespace {

const Metadata kPacked = {{"kiln.pixel", pixel_words(ImageFormat::png, PixelType::rgb9e5)}};

/// Texel n has the colours 2^n (1, 1/2, 1/4), all exact.
Table powers(std::size_t planes) {
    Table table{.width = 4, .height = 2, .channels = {"R", "G", "B", "origin"}, .planes = {}};
    table.channels.resize(planes);
    for (std::size_t k = 0; k < planes; ++k) {
        table.planes.emplace_back(8);
        for (int n = 0; n < 8; ++n)
            table.planes[k][static_cast<std::size_t>(n)] =
                k < 3 ? std::ldexp(1.0F, n - static_cast<int>(k)) : static_cast<float>(n % 4);
    }
    return table;
}

/// By the extension's table of bits, from numbers written out by hand.
TEST(Rgb9e5, BitsLieWhereTheExtensionHasThem) {
    // 1 = 256 * 2^(16 - 24); 0.5 and 0.25 share that exponent.
    EXPECT_EQ(to_rgb9e5({1, 0.5, 0.25}), 16U << 27 | 64U << 18 | 128U << 9 | 256U);
    EXPECT_EQ(to_rgb9e5({0, 0, 0}), 0U);
    EXPECT_EQ(to_rgb9e5({65408, 0, 0}), 31U << 27 | 511U);
    EXPECT_EQ(to_rgb9e5({0, 0, std::ldexp(1.0, -24)}), 1U << 18);  // the least above 0
    const auto back = from_rgb9e5(17U << 27 | 511U << 18 | 1U << 9);
    EXPECT_EQ(back[0], 0);
    EXPECT_EQ(back[1], std::ldexp(1.0, -7));
    EXPECT_EQ(back[2], 511 * std::ldexp(1.0, -7));
}

TEST(Rgb9e5, PngHoldsTheBytesOfTheTextureItself) {
    const Encoded file = encode(powers(3), ImageFormat::png, PixelType::rgb9e5, kPacked);
    const own::Png png = own::read_png(file.bytes);
    ASSERT_EQ(png.colour_type, 6);  // RGBA
    ASSERT_EQ(png.bit_depth, 8);
    for (std::uint32_t n = 0; n < 8; ++n) {
        const std::uint32_t expected = (16 + n) << 27 | 64U << 18 | 128U << 9 | 256U;
        for (std::uint32_t b = 0; b < 4; ++b)
            EXPECT_EQ(png.codes[4 * n + b], expected >> (8 * b) & 0xFF) << n << " " << b;
    }
    EXPECT_EQ(file.quantisation_max, std::vector<double>(3, 0.0));
}

TEST(Rgb9e5, BothFormatsComeBack) {
    for (const ImageFormat format : {ImageFormat::exr, ImageFormat::png}) {
        const Table given = powers(format == ImageFormat::exr ? 4 : 3);
        const Decoded file = decode(encode(given, format, PixelType::rgb9e5, kPacked).bytes);
        EXPECT_EQ(file.pixel, "rgb9e5");
        EXPECT_EQ(file.table.channels, given.channels);
        EXPECT_EQ(file.table.planes, given.planes);
    }
}

TEST(Rgb9e5, AForeignPngOfFourBytesIsLeftAsItIs) {
    const Encoded file = encode(powers(3), ImageFormat::png, PixelType::rgb9e5, {});
    EXPECT_EQ(decode(file.bytes).pixel, "uint8");
}

TEST(Rgb9e5, LossesAreCounted) {
    Table table = powers(3);
    table.planes[0][0] = 1.001F;  // 256.256 of 256ths: off by a quarter of 2^-8
    table.planes[1][1] = -0.5F;
    table.planes[2][2] = 70000;
    const Encoded file = encode(table, ImageFormat::exr, PixelType::rgb9e5, {});
    EXPECT_EQ(file.clamped, (std::vector<std::uint64_t>{0, 1, 1}));
    // Beside 70000 the other two colours of that texel share its exponent: a step is 128.
    EXPECT_NEAR(file.quantisation_max[0], 4, 1e-3);
    EXPECT_NEAR(file.quantisation_max[1], 2, 1e-3);
    const Decoded back = decode(file.bytes);
    EXPECT_EQ(back.table.planes[1][1], 0);
    EXPECT_EQ(back.table.planes[2][2], 65408);
}

TEST(Rgb9e5, OtherNumbersOfChannelsAreRefused) {
    Table two = powers(3);
    two.channels.resize(2);
    two.planes.resize(2);
    EXPECT_THROW(encode(two, ImageFormat::exr, PixelType::rgb9e5, {}), Error);
    EXPECT_THROW(encode(powers(4), ImageFormat::png, PixelType::rgb9e5, {}), Error);
}

}  // namespace
}  // namespace kiln
