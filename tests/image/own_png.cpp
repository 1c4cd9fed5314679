// SPDX-License-Identifier: Apache-2.0
#include <zlib.h>

#include <cstdlib>

#include "tests/image/own_readers.h"

// After the W3C's PNG specification (second edition), sections 5, 9 and 11.
namespace own {
namespace {

std::uint32_t big(std::string_view bytes, std::size_t at) {
    require(bytes.size() >= at + 4, "PNG ends early");
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < 4; ++i)
        value = value << 8U | static_cast<unsigned char>(bytes[at + i]);
    return value;
}

std::uint32_t crc_of(std::string_view bytes) {
    return static_cast<std::uint32_t>(
        crc32(0, reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uInt>(bytes.size())));
}

int paeth(int left, int up, int up_left) {
    const int p = left + up - up_left;
    const int a = std::abs(p - left), b = std::abs(p - up), c = std::abs(p - up_left);
    if (a <= b && a <= c) return left;
    return b <= c ? up : up_left;
}

// Section 9.2; `row` holds the filtered bytes and becomes the plain ones.
void unfilter(int type, std::string& row, const std::string& above, std::size_t step) {
    const auto byte = [](char c) { return static_cast<int>(static_cast<unsigned char>(c)); };
    for (std::size_t i = 0; i < row.size(); ++i) {
        const int left = i >= step ? byte(row[i - step]) : 0;
        const int up = byte(above[i]);
        const int up_left = i >= step ? byte(above[i - step]) : 0;
        const int guess = type == 0   ? 0
                          : type == 1 ? left
                          : type == 2 ? up
                          : type == 3 ? (left + up) / 2
                                      : paeth(left, up, up_left);
        require(type >= 0 && type <= 4, "PNG filter type");
        row[i] = static_cast<char>(byte(row[i]) + guess);
    }
}

void read_codes(Png& file, const std::string& compressed) {
    const std::size_t channels = file.colour_type == 0 ? 1 : file.colour_type == 2 ? 3 : 4;
    const auto value_bytes = static_cast<std::size_t>(file.bit_depth / 8);
    const std::size_t row_bytes = file.width * channels * value_bytes;
    std::string raw(file.height * (row_bytes + 1), '\0');
    auto size = static_cast<uLongf>(raw.size());
    require(uncompress(reinterpret_cast<Bytef*>(raw.data()), &size,
                       reinterpret_cast<const Bytef*>(compressed.data()),
                       static_cast<uLong>(compressed.size())) == Z_OK &&
                size == raw.size(),
            "PNG data does not inflate to its size");
    std::string above(row_bytes, '\0');
    for (std::size_t y = 0; y < file.height; ++y) {
        const std::size_t at = y * (row_bytes + 1);
        std::string row = raw.substr(at + 1, row_bytes);
        unfilter(raw[at], row, above, channels * value_bytes);
        for (std::size_t i = 0; i < row_bytes; i += value_bytes) {
            unsigned code = static_cast<unsigned char>(row[i]);
            if (value_bytes == 2) code = code << 8U | static_cast<unsigned char>(row[i + 1]);
            file.codes.push_back(code);
        }
        above = row;
    }
}

}  // namespace

std::string png_chunk(const std::string& type, const std::string& data) {
    const auto bytes = [](std::uint32_t v) {
        return std::string{static_cast<char>(v >> 24U), static_cast<char>(v >> 16U),
                           static_cast<char>(v >> 8U), static_cast<char>(v)};
    };
    return bytes(static_cast<std::uint32_t>(data.size())) + type + data +
           bytes(crc_of(type + data));
}

Png read_png(std::string_view bytes) {
    require(bytes.starts_with("\x89PNG\r\n\x1a\n"), "not PNG");
    Png file;
    std::string compressed;
    for (std::size_t at = 8; at < bytes.size();) {
        const std::size_t size = big(bytes, at);
        const std::string type(bytes.substr(at + 4, 4));
        const std::string data(bytes.substr(at + 8, size));
        require(big(bytes, at + 8 + size) == crc_of(bytes.substr(at + 4, size + 4)), "PNG CRC");
        file.chunks.emplace_back(type, data);
        if (type == "IDAT") compressed += data;
        at += size + 12;
    }
    require(!file.chunks.empty() && file.chunks.front().first == "IHDR", "PNG without IHDR");
    require(file.chunks.back().first == "IEND", "PNG without IEND");
    const std::string& header = file.chunks.front().second;
    file.width = big(header, 0);
    file.height = big(header, 4);
    file.bit_depth = header.at(8);
    file.colour_type = header.at(9);
    file.interlace = header.at(12);
    read_codes(file, compressed);
    return file;
}

}  // namespace own
