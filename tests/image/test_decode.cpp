// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <random>

#include "server/image/image.h"
#include "tests/image/own_readers.h"
#include "tests/image/tables.h"

namespace {

using namespace kiln;

std::string small_file(ImageFormat format, PixelType pixel) {
    return encode(tables::noise(6, 5, 3, 0, 1), format, pixel, {{"kiln.job", R"({"a":1})"}}).bytes;
}

const std::vector<std::pair<ImageFormat, PixelType>>& kinds() {
    static const std::vector<std::pair<ImageFormat, PixelType>> all = {
        {ImageFormat::exr, PixelType::half},
        {ImageFormat::exr, PixelType::float32},
        {ImageFormat::png, PixelType::uint8},
        {ImageFormat::png, PixelType::uint16}};
    return all;
}

std::string code_of_decode(const std::string& bytes) {
    return tables::code_of([&] { decode(bytes); });
}

/// What decode() says of a file that it refuses; "" when it reads it.
std::string refusal(const std::string& bytes) {
    try {
        decode(bytes);
    } catch (const Error& e) {
        EXPECT_EQ(e.code(), "cannot_decode");
        return e.what();
    }
    return "";
}

/// `file` with `from` replaced by as many bytes `to`, once.
std::string patched(std::string file, const std::string& from, const std::string& to) {
    const std::size_t at = file.find(from);
    if (at == std::string::npos || from.size() != to.size())
        throw std::runtime_error("nothing to patch");
    return file.replace(at, from.size(), to);
}

std::string little(std::uint32_t v) {
    return {static_cast<char>(v), static_cast<char>(v >> 8U), static_cast<char>(v >> 16U),
            static_cast<char>(v >> 24U)};
}

TEST(Decode, TellsFormatPixelAndMetadata) {
    const std::vector<std::string> pixels = {"half", "float", "uint8", "uint16"};
    for (std::size_t i = 0; i < kinds().size(); ++i) {
        const Decoded decoded = decode(small_file(kinds()[i].first, kinds()[i].second));
        EXPECT_EQ(decoded.format, i < 2 ? "exr" : "png");
        EXPECT_EQ(decoded.pixel, pixels[i]);
        EXPECT_EQ(decoded.metadata, (Metadata{{"kiln.job", R"({"a":1})"}}));
        EXPECT_EQ(decoded.table.channels, (std::vector<std::string>{"R", "G", "B"}));
    }
}

TEST(Decode, EveryTruncationIsAnError) {
    for (const auto& [format, pixel] : kinds()) {
        const std::string file = small_file(format, pixel);
        ASSERT_EQ(code_of_decode(file), "");
        for (std::size_t size = 0; size < file.size(); ++size)
            ASSERT_EQ(code_of_decode(file.substr(0, size)), "cannot_decode")
                << size << " of " << file.size() << " bytes";
    }
}

TEST(Decode, EveryFlippedBitOfAPngIsAnError) {  // each byte after the signature is under a CRC-32
    for (const PixelType pixel : {PixelType::uint8, PixelType::uint16}) {
        const std::string file = small_file(ImageFormat::png, pixel);
        for (std::size_t bit = 0; bit < 8 * file.size(); ++bit) {
            std::string broken = file;
            broken[bit / 8] = static_cast<char>(broken[bit / 8] ^ (1 << (bit % 8)));
            ASSERT_EQ(code_of_decode(broken), "cannot_decode") << "byte " << bit / 8;
        }
    }
}

TEST(Decode, BrokenExrEndsInATableOrAnErrorAndNothingElse) {
    std::mt19937 engine(3);
    std::size_t refused = 0;
    for (const PixelType pixel : {PixelType::half, PixelType::float32}) {
        const std::string file = small_file(ImageFormat::exr, pixel);
        for (std::size_t round = 0; round < 2000 + 8 * file.size(); ++round) {
            std::string broken = file;
            const auto flip = [&](std::size_t bit) {
                broken[bit / 8] = static_cast<char>(broken[bit / 8] ^ (1 << (bit % 8)));
            };
            if (round < 8 * file.size())
                flip(round);  // every single bit, then handfuls at random
            else
                for (unsigned n = 0; n < 1 + engine() % 8; ++n) flip(engine() % (8 * file.size()));
            const std::string code =
                code_of_decode(broken);  // anything but kiln::Error ends the test
            ASSERT_TRUE(code.empty() || code == "cannot_decode") << code;
            refused += code.empty() ? 0 : 1;
        }
    }
    EXPECT_GT(refused, 2000U);
}

TEST(Decode, OtherFilesAreRefused) {
    for (const std::string& bytes : {std::string(), std::string("x"), std::string("GIF89a"),
                                     std::string(64, '\0'), std::string("\x76\x2f\x31\x01"),
                                     std::string("\x89PNG\r\n\x1a\n"), std::string("\x89PNG")})
        EXPECT_EQ(code_of_decode(bytes), "cannot_decode");
}

TEST(ExrInput, HugeWindowsAreRefusedBeforeAnythingIsAllocated) {
    const std::string file = small_file(ImageFormat::exr, PixelType::half);
    const std::string window = little(0) + little(0) + little(5) + little(4);
    const auto with = [&](std::uint32_t x0, std::uint32_t y0, std::uint32_t x1, std::uint32_t y1) {
        return refusal(patched(file, window, little(x0) + little(y0) + little(x1) + little(y1)));
    };
    const std::string bound = "dataWindow is empty or larger than 16384";
    EXPECT_NE(with(0, 0, (1U << 20U) - 1, (1U << 20U) - 1).find(bound), std::string::npos);
    EXPECT_NE(with(0, 0, 0x7FFFFFFF, 0).find(bound), std::string::npos);
    EXPECT_NE(with(0x80000000, 0, 0x7FFFFFFF, 0).find(bound), std::string::npos);
    EXPECT_NE(with(0x7FFFFFF0, 0, 0x7FFFFFF5, 4).find(bound), std::string::npos);
    EXPECT_NE(with(5, 0, 0, 4).find(bound), std::string::npos);
    // Within the bound, but no file of this size can hold it.
    EXPECT_NE(with(0, 0, 16383, 16383).find("too short"), std::string::npos);
}

TEST(ExrInput, KindsOfFileThatAreNotReadAreNamed) {
    const std::string file = small_file(ImageFormat::exr, PixelType::half);
    const auto flagged = [&](std::uint32_t flags) {
        std::string other = file;
        other.replace(4, 4, little(2 | flags));
        return refusal(other);
    };
    EXPECT_NE(flagged(0x200).find("tiled"), std::string::npos);
    EXPECT_NE(flagged(0x800).find("deep"), std::string::npos);
    EXPECT_NE(flagged(0x1000).find("multi-part"), std::string::npos);
    EXPECT_NE(flagged(0x4000).find("unknown version flags"), std::string::npos);
    const std::string g(std::string("G\0", 2));
    EXPECT_NE(refusal(patched(file, g + little(1), g + little(0))).find("neither half nor float"),
              std::string::npos);
    EXPECT_NE(refusal(patched(file, g + little(1), g + little(2))).find("different pixel types"),
              std::string::npos);
    EXPECT_NE(refusal(patched(file, g + little(1) + little(0) + little(1),
                              g + little(1) + little(0) + little(2)))
                  .find("subsampled"),
              std::string::npos);
    const std::string zip = std::string("compression\0compression\0", 24) + little(1);
    EXPECT_NE(refusal(patched(file, zip + '\3', zip + '\4')).find("compression other than"),
              std::string::npos);
}

TEST(PngInput, KindsOfFileThatAreNotReadAreNamed) {
    const std::string file = small_file(ImageFormat::png, PixelType::uint8);
    const auto with_header = [&](std::uint32_t width, char depth, char colour, char interlace) {
        const auto big = [](std::uint32_t v) {
            const std::string bytes = little(v);
            return std::string(bytes.rbegin(), bytes.rend());
        };
        const std::string header =
            big(width) + big(5) + depth + colour + std::string(2, '\0') + interlace;
        std::string other = file;
        return refusal(other.replace(8, 25, own::png_chunk("IHDR", header)));
    };
    EXPECT_EQ(with_header(6, 8, 2, 0), "");  // the header as it was
    EXPECT_NE(with_header(6, 8, 2, 1).find("interlaced"), std::string::npos);
    EXPECT_NE(with_header(6, 8, 4, 0).find("only gray, RGB and RGBA"), std::string::npos);
    EXPECT_NE(with_header(6, 4, 0, 0).find("only 8 and 16 bits"), std::string::npos);
    EXPECT_NE(with_header(1U << 20U, 8, 2, 0), "");
    EXPECT_NE(with_header(8192, 16, 2, 0).find("too short"), std::string::npos);
}

TEST(PngInput, AChunkThatAnnouncesTwoGigabytesIsRefusedBeforeItIsAllocated) {
    const std::string file = small_file(ImageFormat::png, PixelType::uint8);
    const std::size_t length = file.find("tEXt") - 4;
    std::string broken = file;
    EXPECT_NE(refusal(broken.replace(length, 4, "\x7f\xff\xff\xff")).find("too large"),
              std::string::npos);
}

}  // namespace
