// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "server/image/image.h"

/// What the image room's own files share; nobody outside includes this.
namespace kiln::codec {

/// Name of the EXR channel of packed colours.
inline constexpr const char* kRgb9e5Channel = "RGB9E5";
/// Start of the PNG text kiln.pixel where R, G, B, A are the bytes of packed colours.
inline constexpr std::string_view kRgb9e5Words = "RGB9_E5";

/// Lines [y, y + lines) of the first three planes as RGB9_E5, with what that costs in `account`.
void pack_rgb9e5(const Table& table, std::size_t y, std::size_t lines, std::uint32_t* out,
                 Encoded& account);
/// The other way: makes planes R, G, B of width x height packed colours.
void unpack_rgb9e5(const std::vector<std::uint32_t>& packed, Table& table);

// Both writers are given a table and metadata that image.cpp has checked.
Encoded encode_exr(const Table& table, PixelType pixel, const Metadata& metadata,
                   unsigned thread_count, const std::function<void()>& between_lines);
Encoded encode_png(const Table& table, PixelType pixel, const Metadata& metadata,
                   const std::function<void()>& between_lines);

Decoded decode_exr(std::string_view bytes);
Decoded decode_png(std::string_view bytes);

inline constexpr std::string_view kExrMagic = "\x76\x2f\x31\x01";
inline constexpr std::string_view kPngMagic = "\x89PNG\r\n\x1a\n";

/// Largest width and height that a file to be written or read may claim: those of an atlas.
inline constexpr std::size_t kDecodeSideMax = 16384;
inline constexpr std::size_t kDecodeChannelsMax = 64;  ///< as many as a job has quantities

/// Throws Error("cannot_decode") unless an image of that shape is within bounds and could have come
/// out of a file of file_bytes. To be called before anything of the image's size is allocated.
void check_decode_size(std::size_t width, std::size_t height, std::size_t channels,
                       std::size_t bytes_per_value, std::size_t file_bytes);

}  // namespace kiln::codec
