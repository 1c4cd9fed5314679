// SPDX-License-Identifier: Apache-2.0
#include <png.h>

#include <algorithm>

#include "server/base/error.h"
#include "server/base/png_input.h"
#include "server/image/codec.h"

namespace kiln::codec {
namespace {

struct Reader {
    explicit Reader(std::string_view given) : bytes(given), in(given) {}
    std::string_view bytes;
    std::vector<png_byte> row;
    Decoded out;
    std::size_t channels = 0;
    int bit_depth = 0;
    PngInput in;
    png_structp png = in.png;
    png_infop info = in.info;
};

bool read_header(Reader& r) {
    if (setjmp(png_jmpbuf(r.png)) != 0) return false;
    png_set_user_limits(r.png, kDecodeSideMax, kDecodeSideMax);
    png_set_chunk_cache_max(r.png, 256);
    png_set_chunk_malloc_max(r.png, 4U << 20U);
    // A damaged text chunk is damage too, not something to step over.
    png_set_crc_action(r.png, PNG_CRC_ERROR_QUIT, PNG_CRC_ERROR_QUIT);
    png_read_info(r.png, r.info);
    return true;
}

void check_header(Reader& r) {
    const auto refuse = [](const std::string& why) { throw Error("cannot_decode", "PNG: " + why); };
    const int colour = png_get_color_type(r.png, r.info);
    if (colour != PNG_COLOR_TYPE_GRAY && colour != PNG_COLOR_TYPE_RGB &&
        colour != PNG_COLOR_TYPE_RGB_ALPHA)
        refuse("only gray, RGB and RGBA images are read, without palette");
    r.bit_depth = png_get_bit_depth(r.png, r.info);
    if (r.bit_depth != 8 && r.bit_depth != 16) refuse("only 8 and 16 bits a channel are read");
    if (png_get_interlace_type(r.png, r.info) != PNG_INTERLACE_NONE)
        refuse("interlaced images are not read");
    r.channels = png_get_channels(r.png, r.info);
    Table& table = r.out.table;
    table.width = png_get_image_width(r.png, r.info);
    table.height = png_get_image_height(r.png, r.info);
    const auto value_bytes = static_cast<std::size_t>(r.bit_depth / 8);
    check_decode_size(table.width, table.height, r.channels, value_bytes, r.bytes.size());

    r.out.format = "png";
    r.out.pixel = r.bit_depth == 8 ? "uint8" : "uint16";
    // A gray image is a table of one channel, which is R in every format.
    const std::vector<std::string> rgba = {"R", "G", "B", "A"};
    table.channels.assign(rgba.begin(), rgba.begin() + static_cast<std::ptrdiff_t>(r.channels));
    table.planes.assign(r.channels, std::vector<float>(table.width * table.height));
    r.row.resize(table.width * r.channels * value_bytes);
}

void take_row(Reader& r, std::size_t y) {
    const double code_max = r.bit_depth == 8 ? 255.0 : 65535.0;
    Table& table = r.out.table;
    for (std::size_t x = 0; x < table.width; ++x)
        for (std::size_t c = 0; c < r.channels; ++c) {
            const std::size_t i = x * r.channels + c;
            const unsigned code =
                r.bit_depth == 8 ? r.row[i] : (unsigned{r.row[2 * i]} << 8U | r.row[2 * i + 1]);
            table.planes[c][y * table.width + x] = static_cast<float>(code / code_max);
        }
}

bool read_rows(Reader& r) {
    if (setjmp(png_jmpbuf(r.png)) != 0) return false;
    for (std::size_t y = 0; y < r.out.table.height; ++y) {
        png_read_row(r.png, r.row.data(), nullptr);
        take_row(r, y);
    }
    png_read_end(r.png, r.info);
    return true;
}

/// Four planes of bytes over 255 to the colours that they are.
void unpack(Decoded& file) {
    Table& table = file.table;
    std::vector<std::uint32_t> packed(table.width * table.height);
    for (std::size_t n = 0; n < packed.size(); ++n)
        for (unsigned b = 0; b < 4; ++b)
            packed[n] |= static_cast<std::uint32_t>(table.planes[b][n] * 255.0F + 0.5F) << (8 * b);
    unpack_rgb9e5(packed, table);
    file.pixel = "rgb9e5";
}

}  // namespace

Decoded decode_png(std::string_view bytes) {
    Reader reader(bytes);
    const auto fail = [&] { throw Error("cannot_decode", "PNG: " + reader.in.error); };
    if (!read_header(reader)) fail();
    check_header(reader);
    if (!read_rows(reader)) fail();

    png_textp texts = nullptr;
    const int count = png_get_text(reader.png, reader.info, &texts, nullptr);
    for (int i = 0; i < count; ++i)
        reader.out.metadata.emplace_back(
            texts[i].key, std::string(texts[i].text == nullptr ? "" : texts[i].text));
    for (const auto& [key, value] : reader.out.metadata)
        if (key == "kiln.pixel" && value.starts_with(kRgb9e5Words) && reader.channels == 4 &&
            reader.bit_depth == 8)
            unpack(reader.out);
    return std::move(reader.out);
}

}  // namespace kiln::codec
