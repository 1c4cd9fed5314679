// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <string>
#include <string_view>

#include "server/image/image.h"

/// What the image room's own files share; nobody outside includes this.
namespace kiln::codec {

// Both writers are given a table and metadata that image.cpp has checked.
Encoded encode_exr(const Table& table, PixelType pixel, const Metadata& metadata,
                   unsigned thread_count, const std::function<void()>& between_lines);
Encoded encode_png(const Table& table, PixelType pixel, const Metadata& metadata,
                   const std::function<void()>& between_lines);

Decoded decode_exr(std::string_view bytes);
Decoded decode_png(std::string_view bytes);

inline constexpr std::string_view kExrMagic = "\x76\x2f\x31\x01";
inline constexpr std::string_view kPngMagic = "\x89PNG\r\n\x1a\n";

/// Largest width and height that a file to be read may claim: twice what a job may ask for.
inline constexpr std::size_t kDecodeSideMax = 8192;
inline constexpr std::size_t kDecodeChannelsMax = 64;  ///< as many as a job has quantities

/// Throws Error("cannot_decode") unless an image of that shape is within bounds and could have come
/// out of a file of file_bytes. To be called before anything of the image's size is allocated.
void check_decode_size(std::size_t width, std::size_t height, std::size_t channels,
                       std::size_t bytes_per_value, std::size_t file_bytes);

}  // namespace kiln::codec
