// SPDX-License-Identifier: Apache-2.0
#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "tests/image/own_readers.h"

// After "OpenEXR File Layout" (openexr.com) and the ZIP scheme described in its technical
// introduction.
namespace own {
namespace {

struct Cursor {
    std::string_view bytes;
    std::size_t at = 0;

    std::uint64_t little(std::size_t count) {
        require(bytes.size() - at >= count, "EXR ends early");
        std::uint64_t value = 0;
        for (std::size_t i = 0; i < count; ++i)
            value |= std::uint64_t{static_cast<unsigned char>(bytes[at + i])} << (8 * i);
        at += count;
        return value;
    }
    std::uint32_t u32() { return static_cast<std::uint32_t>(little(4)); }
    std::string word() {
        const std::size_t end = bytes.find('\0', at);
        require(end != std::string_view::npos, "EXR ends early");
        const std::string text(bytes.substr(at, end - at));
        at = end + 1;
        return text;
    }
    std::string take(std::size_t count) {
        require(bytes.size() - at >= count, "EXR ends early");
        at += count;
        return std::string(bytes.substr(at - count, count));
    }
};

float half_to_float(unsigned bits) {
    const float sign = (bits & 0x8000U) != 0 ? -1.0F : 1.0F;
    const int exponent = static_cast<int>(bits >> 10U & 31U);
    const int mantissa = static_cast<int>(bits & 1023U);
    if (exponent == 31)
        return std::numeric_limits<float>::quiet_NaN();  // or infinite: never expected
    if (exponent == 0) return sign * std::ldexp(static_cast<float>(mantissa), -24);
    return sign * std::ldexp(static_cast<float>(1024 + mantissa), exponent - 25);
}

std::string inflated(const std::string& data, std::size_t raw_size) {
    if (data.size() == raw_size) return data;  // stored as it is when it would not shrink
    std::string swapped(raw_size, '\0');
    auto size = static_cast<uLongf>(raw_size);
    require(uncompress(reinterpret_cast<Bytef*>(swapped.data()), &size,
                       reinterpret_cast<const Bytef*>(data.data()),
                       static_cast<uLong>(data.size())) == Z_OK,
            "EXR block does not inflate");
    require(size == raw_size, "EXR block has another size");
    for (std::size_t i = 1; i < raw_size;
         ++i)  // the predictor: differences from the byte before, plus 128
        swapped[i] = static_cast<char>(static_cast<unsigned char>(swapped[i - 1]) +
                                       static_cast<unsigned char>(swapped[i]) - 128);
    std::string raw(raw_size, '\0');  // even bytes come first, odd bytes second
    for (std::size_t i = 0; i < raw_size; ++i)
        raw[i] = swapped[i % 2 == 0 ? i / 2 : (raw_size + 1) / 2 + i / 2];
    return raw;
}

void read_header(Cursor& in, Exr& file) {
    require(in.u32() == 20000630, "not EXR");
    file.version_and_flags = in.u32();
    for (std::string name = in.word(); !name.empty(); name = in.word()) {
        const std::string type = in.word();
        const std::uint32_t size = in.u32();
        require(file.attributes.try_emplace(name, type, in.take(size)).second, "attribute twice");
    }
    Cursor list{file.attributes.at("channels").second};
    for (std::string name = list.word(); !name.empty(); name = list.word()) {
        file.channels.push_back(name);
        file.channel_types.push_back(static_cast<int>(list.u32()));
        list.u32();
        require(list.u32() == 1 && list.u32() == 1, "EXR channel is subsampled");
    }
    Cursor window{file.attributes.at("dataWindow").second};
    require(window.u32() == 0 && window.u32() == 0, "EXR window does not start at the origin");
    file.width = window.u32() + 1;
    file.height = window.u32() + 1;
    require(file.attributes.at("compression").second == std::string(1, '\3'), "EXR is not ZIP");
    require(file.attributes.at("lineOrder").second == std::string(1, '\0'), "EXR runs upwards");
}

void read_lines(Cursor block, Exr& file, std::size_t first, std::size_t lines) {
    for (std::size_t y = first; y < first + lines; ++y)
        for (std::size_t c = 0; c < file.channels.size(); ++c)
            for (std::size_t x = 0; x < file.width; ++x)
                file.planes[c][y * file.width + x] =
                    file.channel_types[c] == 1
                        ? half_to_float(static_cast<unsigned>(block.little(2)))
                        : std::bit_cast<float>(block.u32());
}

}  // namespace

Exr read_exr(std::string_view bytes) {
    Cursor in{bytes};
    Exr file;
    read_header(in, file);
    file.planes.assign(file.channels.size(), std::vector<float>(file.width * file.height));
    std::size_t texel_bytes = 0;
    for (const int type : file.channel_types) texel_bytes += type == 1 ? 2 : 4;

    const std::size_t blocks = (file.height + 15) / 16;
    std::vector<std::uint64_t> offsets;
    for (std::size_t b = 0; b < blocks; ++b) offsets.push_back(in.little(8));
    for (std::size_t b = 0; b < blocks; ++b) {
        Cursor at{bytes, offsets[b]};
        require(at.u32() == b * 16, "EXR block starts at another line");
        const std::string data = at.take(at.u32());
        const std::size_t lines = std::min<std::size_t>(16, file.height - b * 16);
        const std::string raw = inflated(data, lines * file.width * texel_bytes);
        read_lines(Cursor{raw}, file, b * 16, lines);
    }
    return file;
}

}  // namespace own
