// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <map>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

/// Readers that share no line with OpenEXR, libpng or server/image: written from the two formats'
/// specifications on top of zlib alone. They throw std::runtime_error on anything unexpected.
namespace own {

struct Exr {
    std::uint32_t version_and_flags = 0;
    std::map<std::string, std::pair<std::string, std::string>> attributes;  ///< name: type, bytes
    std::vector<std::string> channels;                                      ///< in file order
    std::vector<int> channel_types;                                         ///< 1 half, 2 float
    std::size_t width = 0, height = 0;
    std::vector<std::vector<float>> planes;  ///< in file order, row-major
};
/// ZIP-compressed scan-line files whose data window starts at the origin.
Exr read_exr(std::string_view bytes);

struct Png {
    std::size_t width = 0, height = 0;
    int bit_depth = 0, colour_type = 0, interlace = 0;
    std::vector<std::pair<std::string, std::string>> chunks;  ///< type, data; in file order
    std::vector<unsigned> codes;                              ///< row-major, channels interleaved
};
Png read_png(std::string_view bytes);

/// A chunk with its length and CRC-32.
std::string png_chunk(const std::string& type, const std::string& data);

inline void require(bool condition, const char* what) {
    if (!condition) throw std::runtime_error(what);
}

}  // namespace own
