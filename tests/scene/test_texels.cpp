// SPDX-License-Identifier: Apache-2.0
#include "server/scene/texels.h"

#include <gtest/gtest.h>

#include "server/scene/bounds.h"
#include "tests/scene/scenes.h"

namespace kiln {
namespace {

std::uint64_t plenty() { return kSceneTexelsMax; }

/// One gray of each kind and a corner that differs.
std::vector<unsigned char> texels(std::size_t count) {
    std::vector<unsigned char> data(4 * count, 100);
    data[0] = 0, data[1] = 50, data[2] = 255, data[3] = 7;
    return data;
}

TEST(Texels, ExtremesOfEveryChannelAreThoseOfThePng) {
    std::uint64_t left = plenty();
    const ImageLook look = look_at_image(test::png_of(5, 3, texels(15)), left);
    ASSERT_TRUE(look.texels) << look.why_not;
    const double low[] = {0, 50, 100, 7}, high[] = {100, 100, 255, 100};
    for (std::size_t c = 0; c < 4; ++c) {
        EXPECT_DOUBLE_EQ(look.texels->lo[c], low[c] / 255) << c;
        EXPECT_DOUBLE_EQ(look.texels->hi[c], high[c] / 255) << c;
    }
    EXPECT_EQ(left, plenty() - 15);
}

TEST(Texels, AJpegIsReadToItsOwnAccuracy) {
    std::vector<unsigned char> data(4 * 256);
    for (std::size_t i = 0; i < 256; ++i)
        for (std::size_t c = 0; c < 3; ++c) data[4 * i + c] = i < 128 ? 60 : 200;
    std::uint64_t left = plenty();
    const ImageLook look = look_at_image(test::jpeg_of(16, 16, data), left);
    ASSERT_TRUE(look.texels) << look.why_not;
    // Quality 100 of a step between blocks: rounding of the transform and of YCbCr, two codes.
    for (std::size_t c = 0; c < 3; ++c) {
        EXPECT_NEAR(look.texels->lo[c], 60 / 255.0, 2.5 / 255) << c;
        EXPECT_NEAR(look.texels->hi[c], 200 / 255.0, 2.5 / 255) << c;
    }
    EXPECT_EQ(look.texels->lo[3], 1);
}

TEST(Texels, WhatIsNotReadIsSaid) {
    std::uint64_t left = plenty();
    EXPECT_NE(look_at_image("RIFF....WEBP", left).why_not.find("no PNG or JPEG"),
              std::string::npos);
    const std::string interlaced = test::png_of(4, 4, texels(16), true);
    EXPECT_NE(look_at_image(interlaced, left).why_not.find("interlaced"), std::string::npos);
    left = 10;
    const ImageLook late = look_at_image(test::png_of(4, 4, texels(16)), left);
    EXPECT_FALSE(late.texels);
    EXPECT_NE(late.why_not.find("beyond which"), std::string::npos);
    EXPECT_EQ(left, 10u);
    EXPECT_NE(refuse_size(4097, 4096, left).find("at most"), std::string::npos);
}

std::string big_endian(std::uint32_t word) {
    std::string bytes;
    for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(word >> shift & 0xFF);
    return bytes;
}

/// PNG specification, annex D.
std::string chunk(const std::string& type, const std::string& data) {
    std::uint32_t crc = 0xFFFFFFFF;
    for (const char c : type + data) {
        crc ^= static_cast<unsigned char>(c);
        for (int bit = 0; bit < 8; ++bit) crc = crc & 1 ? 0xEDB88320U ^ crc >> 1 : crc >> 1;
    }
    return big_endian(static_cast<std::uint32_t>(data.size())) + type + data + big_endian(~crc);
}

// What is compressed behind the last row may inflate to a thousand times its size: here it is no
// deflate at all (RFC 1951: block type 3), which only who inflates it finds out.
TEST(Texels, WhatStandsBehindTheLastRowIsNotInflated) {
    const std::string stored("\x78\x01\x00\x05\x00\xFA\xFF\x00\x33\x66\x99\xCC", 12);
    const std::string png =
        "\x89PNG\r\n\x1A\n" +
        chunk("IHDR", big_endian(1) + big_endian(1) + std::string("\x08\x06\x00\x00\x00", 5)) +
        chunk("IDAT", stored + stored.substr(2) + std::string(100, '\x07')) + chunk("IEND", "");
    std::uint64_t left = plenty();
    const ImageLook look = look_at_image(png, left);
    ASSERT_TRUE(look.texels) << look.why_not;
    EXPECT_DOUBLE_EQ(look.texels->lo[1], 0.4);
    EXPECT_DOUBLE_EQ(look.texels->hi[3], 0.8);
}

TEST(Texels, SrgbIsUndone) {
    EXPECT_EQ(linear_from_srgb(0), 0);
    EXPECT_DOUBLE_EQ(linear_from_srgb(1), 1);
    // IEC 61966-2-1: middle gray.
    EXPECT_NEAR(linear_from_srgb(0.5), 0.21404114, 1e-8);
    EXPECT_NEAR(linear_from_srgb(0.04), 0.04 / 12.92, 1e-15);
}

}  // namespace
}  // namespace kiln
