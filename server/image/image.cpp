// SPDX-License-Identifier: Apache-2.0
#include "server/image/image.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <string>

#include "server/base/error.h"
#include "server/base/rgb9e5.h"
#include "server/image/codec.h"

namespace kiln {
namespace {

[[noreturn]] void cannot_encode(const std::string& why) { throw Error("cannot_encode", why); }

void check_shape(const Table& table) {
    if (table.width == 0 || table.height == 0) cannot_encode("the table has no texels");
    if (table.width > codec::kDecodeSideMax || table.height > codec::kDecodeSideMax)
        cannot_encode("the table is larger than " + std::to_string(codec::kDecodeSideMax) +
                      " texels on a side");
    if (table.planes.empty() || table.planes.size() > codec::kDecodeChannelsMax)
        cannot_encode("a table has 1 to " + std::to_string(codec::kDecodeChannelsMax) +
                      " channels, this one has " + std::to_string(table.planes.size()));
    if (table.channels.size() != table.planes.size())
        cannot_encode("the table has " + std::to_string(table.planes.size()) + " planes and " +
                      std::to_string(table.channels.size()) + " channel names");
    for (const auto& plane : table.planes)
        if (plane.size() != table.width * table.height)
            cannot_encode("a plane of the table has " + std::to_string(plane.size()) +
                          " values instead of width x height");
    const std::set<std::string> names(table.channels.begin(), table.channels.end());
    if (names.size() != table.channels.size() || names.contains(""))
        cannot_encode("channel names must be there and differ from each other");
}

void check_finite(const Table& table) {
    for (std::size_t channel = 0; channel < table.planes.size(); ++channel) {
        const auto& plane = table.planes[channel];
        const auto bad =
            std::find_if(plane.begin(), plane.end(), [](float v) { return !std::isfinite(v); });
        if (bad == plane.end()) continue;
        const auto texel = static_cast<std::size_t>(bad - plane.begin());
        throw Error("non_finite", "channel " + table.channels[channel] + " is " +
                                      (std::isnan(*bad) ? "not a number" : "infinite") +
                                      " at column " + std::to_string(texel % table.width) +
                                      ", row " + std::to_string(texel / table.width));
    }
}

bool is_text(char c) { return (c >= ' ' && c <= '~') || c == '\n'; }

bool is_key_char(char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_' || c == '.';
}

// EXR holds attribute names of up to 31 bytes, PNG's tEXt holds Latin-1: what both hold alike is
// ASCII.
void check_metadata(const Metadata& metadata) {
    std::set<std::string> seen;
    for (const auto& [key, value] : metadata) {
        if (!key.starts_with("kiln.") || key.size() > 31 || !std::ranges::all_of(key, is_key_char))
            cannot_encode("a metadata key is not of the form kiln.name, at most 31 characters");
        if (!seen.insert(key).second) cannot_encode("metadata key " + key + " is there twice");
        if (!std::ranges::all_of(value, is_text))
            cannot_encode("the value of metadata key " + key + " is not printable ASCII");
    }
}

}  // namespace

namespace codec {

void check_decode_size(std::size_t width, std::size_t height, std::size_t channels,
                       std::size_t bytes_per_value, std::size_t file_bytes) {
    const auto refuse = [](const std::string& why) { throw Error("cannot_decode", why); };
    if (width == 0 || height == 0 || width > kDecodeSideMax || height > kDecodeSideMax)
        refuse("an image of " + std::to_string(width) + " x " + std::to_string(height) +
               " texels; at least 1 and at most " + std::to_string(kDecodeSideMax) +
               " on a side can be read");
    if (channels == 0 || channels > kDecodeChannelsMax)
        refuse("an image of " + std::to_string(channels) + " channels; 1 to " +
               std::to_string(kDecodeChannelsMax) + " can be read");
    // Deflate reaches 1032:1 at most (zlib, "Technical Details"), run lengths in EXR 64:1: a larger
    // claim is a lie. All factors are small enough for 64 bits: 2^13 * 2^13 * 2^6 * 2^2.
    if (width * height * channels * bytes_per_value / 1032 > file_bytes)
        refuse("the file is too short for the image that its header announces");
}

void pack_rgb9e5(const Table& table, std::size_t y, std::size_t lines, std::uint32_t* out,
                 Encoded& account) {
    const std::size_t first = y * table.width;
    for (std::size_t i = 0; i < lines * table.width; ++i) {
        std::array<double, 3> c{};
        for (std::size_t k = 0; k < 3; ++k) c[k] = double(table.planes[k][first + i]);
        out[i] = to_rgb9e5(c);
        const std::array<double, 3> back = from_rgb9e5(out[i]);
        for (std::size_t k = 0; k < 3; ++k) {
            if (c[k] < 0 || c[k] > kRgb9e5Most)
                ++account.clamped[k];
            else
                account.quantisation_max[k] =
                    std::max(account.quantisation_max[k], std::abs(back[k] - c[k]));
        }
    }
}

void unpack_rgb9e5(const std::vector<std::uint32_t>& packed, Table& table) {
    table.channels = {"R", "G", "B"};
    table.planes.assign(3, std::vector<float>(packed.size()));
    for (std::size_t n = 0; n < packed.size(); ++n) {
        const std::array<double, 3> c = from_rgb9e5(packed[n]);
        for (std::size_t k = 0; k < 3; ++k) table.planes[k][n] = static_cast<float>(c[k]);
    }
}

}  // namespace codec

Encoded encode(const Table& table, ImageFormat format, PixelType pixel, const Metadata& metadata,
               unsigned thread_count, const std::function<void()>& between_lines) {
    check_shape(table);
    check_metadata(metadata);
    check_finite(table);
    if (pixel == PixelType::rgb9e5 && table.planes.size() != 3 &&
        !(table.planes.size() == 4 && format == ImageFormat::exr))
        cannot_encode("rgb9e5 holds three channels, in EXR with where they come from as a fourth");
    return format == ImageFormat::exr
               ? codec::encode_exr(table, pixel, metadata, thread_count, between_lines)
               : codec::encode_png(table, pixel, metadata, between_lines);
}

Decoded decode(std::string_view bytes) {
    if (bytes.starts_with(codec::kExrMagic)) return codec::decode_exr(bytes);
    if (bytes.starts_with(codec::kPngMagic)) return codec::decode_png(bytes);
    throw Error("cannot_decode",
                "the file is neither EXR nor PNG (its first bytes are not theirs)");
}

}  // namespace kiln
