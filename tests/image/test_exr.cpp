// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>
#include <set>

#include "server/image/image.h"
#include "tests/image/own_readers.h"
#include "tests/image/tables.h"

namespace {

using namespace kiln;

const Metadata kSome = {{"kiln.job", R"({"a":1})"}, {"kiln.color", "linear data"}};

Encoded exr(const Table& table, PixelType pixel) {
    return encode(table, ImageFormat::exr, pixel, kSome);
}

// Where a table's channel stands in the file, whose channels are sorted.
std::size_t position(const own::Exr& file, const std::string& name) {
    const auto at = std::find(file.channels.begin(), file.channels.end(), name);
    if (at == file.channels.end()) throw std::runtime_error("the file has no channel " + name);
    return static_cast<std::size_t>(at - file.channels.begin());
}

std::string file_name(std::size_t channel, std::size_t channels) {
    return channels > 4 ? tables::names()[channel] : std::string(1, "RGBA"[channel]);
}

// Half an ulp of binary16 at v: 11 significant bits, exponents from -14 on (IEEE 754-2019,
// table 3.5).
double half_ulp(float v) {
    const int exponent = v == 0 ? -14 : std::max(std::ilogb(v), -14);
    return std::ldexp(1.0, exponent - 11);
}

struct Shape {
    std::size_t width, height, channels;
};

void PrintTo(const Shape& shape, std::ostream* out) {
    *out << shape.width << " x " << shape.height << " x " << shape.channels;
}

class ExrShapes : public testing::TestWithParam<Shape> {};

TEST_P(ExrShapes, FloatComesBackBitForBit) {
    const auto [width, height, channels] = GetParam();
    Table table = tables::noise(width, height, channels, -3, 1e6F);
    table.planes[0][0] = -0.0F;
    table.planes[channels - 1][width * height - 1] = std::numeric_limits<float>::denorm_min();
    const Encoded encoded = exr(table, PixelType::float32);
    const own::Exr file = own::read_exr(encoded.bytes);
    const Decoded decoded = decode(encoded.bytes);

    EXPECT_EQ(encoded.extension, "exr");
    ASSERT_EQ(file.channels.size(), channels);
    ASSERT_EQ(file.width, width);
    ASSERT_EQ(file.height, height);
    ASSERT_EQ(decoded.table.planes.size(), channels);
    EXPECT_EQ(decoded.pixel, "float");
    for (std::size_t c = 0; c < channels; ++c) {
        const std::string name = file_name(c, channels);
        const std::size_t stored = position(file, name);
        EXPECT_EQ(file.channel_types[stored], 2);
        const std::size_t read = channels > 4 ? stored : c;  // no kiln.quantities: the file's order
        EXPECT_EQ(decoded.table.channels[read], name);
        for (std::size_t i = 0; i < width * height; ++i) {
            const auto bits = std::bit_cast<std::uint32_t>(table.planes[c][i]);
            ASSERT_EQ(std::bit_cast<std::uint32_t>(file.planes[stored][i]), bits) << c << " " << i;
            ASSERT_EQ(std::bit_cast<std::uint32_t>(decoded.table.planes[read][i]), bits);
        }
        EXPECT_EQ(encoded.quantisation_max.at(c), 0.0);
        EXPECT_EQ(encoded.clamped.at(c), 0U);
    }
}

TEST_P(ExrShapes, HalfIsTheNearestHalf) {
    const auto [width, height, channels] = GetParam();
    const Table table = tables::noise(width, height, channels, -2, 2);
    const Encoded encoded = exr(table, PixelType::half);
    const own::Exr file = own::read_exr(encoded.bytes);
    for (std::size_t c = 0; c < channels; ++c) {
        const std::size_t stored = position(file, file_name(c, channels));
        EXPECT_EQ(file.channel_types[stored], 1);
        double worst = 0;
        for (std::size_t i = 0; i < width * height; ++i) {
            const float given = table.planes[c][i];
            const double difference = std::abs(double(file.planes[stored][i]) - double(given));
            ASSERT_LE(difference, half_ulp(given)) << given;
            worst = std::max(worst, difference);
        }
        EXPECT_EQ(encoded.quantisation_max.at(c),
                  worst);  // differences of floats are exact in double
        EXPECT_EQ(encoded.clamped.at(c), 0U);
    }
}

// Around the block of 16 lines that ZIP compresses, one texel, and the widest and highest table of
// a job.
INSTANTIATE_TEST_SUITE_P(Shapes, ExrShapes,
                         testing::Values(Shape{1, 1, 1}, Shape{1, 1, 5}, Shape{7, 5, 2},
                                         Shape{16, 16, 3}, Shape{33, 17, 4}, Shape{20, 40, 5},
                                         Shape{4096, 1, 1}, Shape{1, 4096, 2}));

TEST(Exr, HalfRoundsTiesToEven) {
    const std::vector<float> given = {1 + 0x1p-11F, 1 + 3 * 0x1p-11F, -1 - 0x1p-11F, 0x1p-25F,
                                      3 * 0x1p-25F, 2049.0F,          2051.0F};
    const std::vector<float> expected = {1, 1 + 0x1p-9F, -1, 0, 0x1p-23F, 2048, 2052};
    const own::Exr file = own::read_exr(exr(tables::of(given), PixelType::half).bytes);
    EXPECT_EQ(file.planes.at(0), expected);
}

TEST(Exr, HalfClampsToItsLargestFiniteAndCounts) {
    const std::vector<float> given = {65504.0F, 65504.01F, 65519.0F, 65520.0F,
                                      1e30F,    -65504.0F, -1e30F,   0.25F};
    const Encoded encoded = exr(tables::of(given), PixelType::half);
    const own::Exr file = own::read_exr(encoded.bytes);
    const std::vector<float> expected = {65504, 65504, 65504, 65504, 65504, -65504, -65504, 0.25F};
    EXPECT_EQ(file.planes.at(0), expected);
    EXPECT_EQ(encoded.clamped.at(0), 5U);
    EXPECT_EQ(encoded.quantisation_max.at(0), 0.0);  // what fits here is stored exactly
}

TEST(Exr, HeaderHoldsTheTableAndItsMetadataAndNothingElse) {
    const own::Exr file = own::read_exr(exr(tables::noise(5, 3, 2, 0, 1), PixelType::half).bytes);
    EXPECT_EQ(file.version_and_flags, 2U);  // version 2; no tiles, parts, deep data or long names
    std::set<std::string> names;
    for (const auto& [name, attribute] : file.attributes) names.insert(name);
    const std::set<std::string> expected = {
        "channels", "compression", "dataWindow",       "displayWindow",      "kiln.color",
        "kiln.job", "lineOrder",   "pixelAspectRatio", "screenWindowCenter", "screenWindowWidth"};
    EXPECT_EQ(names, expected);
    const auto& job = file.attributes.at("kiln.job");
    EXPECT_EQ(job.first, "string");
    EXPECT_EQ(job.second, R"({"a":1})");
    EXPECT_EQ(file.channels, (std::vector<std::string>{"G", "R"}));
}

TEST(Exr, MoreThanFourChannelsAreNamedByQuantityAndKeepTheJobsOrder) {
    Table table = tables::noise(3, 2, 5, 0, 1);
    std::swap(table.channels[0], table.channels[4]);
    Metadata metadata;
    std::string words;
    for (const auto& name : table.channels) words += (words.empty() ? "" : " ") + name;
    metadata.emplace_back("kiln.quantities", words);
    const Decoded decoded =
        decode(encode(table, ImageFormat::exr, PixelType::float32, metadata).bytes);
    EXPECT_EQ(decoded.table.channels, table.channels);
    EXPECT_EQ(decoded.table.planes, table.planes);
    EXPECT_EQ(decoded.metadata, metadata);
}

TEST(Exr, EqualTablesGiveEqualBytes) {
    const Table table = tables::noise(64, 64, 2, 0, 1);
    EXPECT_EQ(exr(table, PixelType::half).bytes, exr(table, PixelType::half).bytes);
    Table other = table;
    other.planes[1][5] += 0.25F;
    EXPECT_NE(exr(table, PixelType::half).bytes, exr(other, PixelType::half).bytes);
}

TEST(Exr, ThreadsDoNotChangeTheBytes) {
    const Table table =
        tables::noise(1000, 1050, 1, 0, 1);  // more than a million values: threads are used
    for (const PixelType pixel : {PixelType::half, PixelType::float32}) {
        const auto with = [&](unsigned threads) {
            return encode(table, ImageFormat::exr, pixel, kSome, threads);
        };
        const Encoded one = with(1);
        for (const unsigned threads : {0U, 2U, 5U}) {
            const Encoded many = with(threads);
            EXPECT_TRUE(one.bytes == many.bytes) << threads << " threads";
            EXPECT_EQ(one.quantisation_max, many.quantisation_max);
        }
    }
}

TEST(Exr, IntegersAreRefused) {
    for (const PixelType pixel : {PixelType::uint8, PixelType::uint16})
        EXPECT_EQ(tables::code_of([&] { exr(tables::noise(2, 2, 1, 0, 1), pixel); }),
                  "cannot_encode");
}

TEST(Encode, NonFiniteValuesAreRefusedByPlace) {
    for (const float bad :
         {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
          -std::numeric_limits<float>::infinity()}) {
        Table table = tables::noise(4, 3, 2, 0, 1);
        table.planes[1][6] = bad;
        for (const auto& [format, pixel] : {std::pair{ImageFormat::exr, PixelType::half},
                                            std::pair{ImageFormat::exr, PixelType::float32},
                                            std::pair{ImageFormat::png, PixelType::uint8}}) {
            try {
                encode(table, format, pixel, kSome);
                ADD_FAILURE() << "encoded " << bad;
            } catch (const Error& e) {
                EXPECT_EQ(e.code(), "non_finite");
                EXPECT_NE(std::string(e.what()).find("split_sum_bias"), std::string::npos);
                EXPECT_NE(std::string(e.what()).find("column 2, row 1"), std::string::npos);
            }
        }
    }
}

TEST(Encode, MalformedTablesAreRefused) {
    const Table good = tables::noise(4, 3, 2, 0, 1);
    const std::vector<std::function<void(Table&)>> breaks = {
        [](Table& t) { t.width = 0; },
        [](Table& t) { t.height = 4; },
        [](Table& t) { t.channels.pop_back(); },
        [](Table& t) { t.planes.clear(), t.channels.clear(); },
        [](Table& t) { t.planes[1].pop_back(); },
        [](Table& t) { t.channels[1] = t.channels[0]; },
        [](Table& t) { t.channels[1] = ""; },
        [](Table& t) { t.width = 12'000, t.height = 1; },
    };
    EXPECT_EQ(tables::code_of([&] { exr(good, PixelType::half); }), "");
    for (std::size_t i = 0; i < breaks.size(); ++i) {
        Table table = good;
        breaks[i](table);
        EXPECT_EQ(tables::code_of([&] { exr(table, PixelType::half); }), "cannot_encode") << i;
    }
}

TEST(Encode, MetadataThatAFormatCannotHoldIsRefused) {
    const Table table = tables::noise(2, 2, 1, 0, 1);
    for (const Metadata& metadata :
         std::vector<Metadata>{{{"job", "x"}},
                               {{"kiln.a_key_of_more_than_31_letters_", "x"}},
                               {{"kiln.Job", "x"}},
                               {{"kiln.job", std::string("a\0b", 3)}},
                               {{"kiln.job", "\xce\xb1"}},
                               {{"kiln.job", "x"}, {"kiln.job", "y"}}})
        EXPECT_EQ(
            tables::code_of([&] { encode(table, ImageFormat::exr, PixelType::half, metadata); }),
            "cannot_encode");
}

}  // namespace
