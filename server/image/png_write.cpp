// SPDX-License-Identifier: Apache-2.0
#include <png.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <exception>

#include "server/base/error.h"
#include "server/image/codec.h"

namespace kiln::codec {
namespace {

// Named so that equal tables give equal bytes whatever libpng's defaults become.
constexpr int kDeflateLevel = 4;
constexpr int kFilter = PNG_FILTER_PAETH;
constexpr int kStrategy =
    1;  // zlib Z_FILTERED: fits Paeth residuals, a third faster than the default

constexpr std::size_t kLinesBetween = 16;

// All that must outlive a longjmp out of libpng stands here, outside the function that calls
// setjmp.
struct Writer {
    const Table& table;
    Encoded& out;
    int bit_depth;
    int colour_type;
    std::size_t file_channels;
    bool packed;
    std::vector<png_byte> row;
    std::vector<png_text> texts;
    const std::function<void()>& between_lines;
    std::string error;
    std::exception_ptr thrown;
    png_structp png = nullptr;
    png_infop info = nullptr;

    ~Writer() { png_destroy_write_struct(&png, &info); }
};

[[noreturn]] void on_error(png_structp png, png_const_charp message) {
    static_cast<Writer*>(png_get_error_ptr(png))->error = message;
    png_longjmp(png, 1);
}

void on_warning(png_structp, png_const_charp) {}

void on_write(png_structp png, png_bytep data, png_size_t byte_count) {
    auto& writer = *static_cast<Writer*>(png_get_io_ptr(png));
    bool failed = false;
    try {
        writer.out.bytes.append(reinterpret_cast<const char*>(data), byte_count);
    } catch (...) {
        // No exception may pass through libpng's C frames.
        writer.thrown = std::current_exception();
        failed = true;
    }
    if (failed) png_error(png, "out of memory");
}

void on_flush(png_structp) {}

void put(std::vector<png_byte>& row, std::size_t index, unsigned code, int bit_depth) {
    if (bit_depth == 8) {
        row[index] = static_cast<png_byte>(code);
    } else {
        row[2 * index] = static_cast<png_byte>(code >> 8);  // PNG is big-endian
        row[2 * index + 1] = static_cast<png_byte>(code & 0xFF);
    }
}

// Quantises row y; texels of channels that the table lacks stay 0.
void fill_row(Writer& w, std::size_t y) {
    const double code_max = w.bit_depth == 8 ? 255.0 : 65535.0;
    for (std::size_t c = 0; c < w.table.planes.size(); ++c) {
        const float* in = w.table.planes[c].data() + y * w.table.width;
        double worst = w.out.quantisation_max[c];
        for (std::size_t x = 0; x < w.table.width; ++x) {
            const double given = double(in[x]);
            const double code = std::floor(std::clamp(given, 0.0, 1.0) * code_max + 0.5);
            if (given < 0.0 || given > 1.0)
                ++w.out.clamped[c];
            else
                worst = std::max(worst, std::abs(code / code_max - given));
            put(w.row, x * w.file_channels + c, static_cast<unsigned>(code), w.bit_depth);
        }
        w.out.quantisation_max[c] = worst;
    }
}

// The four bytes of a packed colour, least first, whatever this machine's order.
void fill_packed_row(Writer& w, std::size_t y) {
    std::vector<std::uint32_t> packed(w.table.width);
    pack_rgb9e5(w.table, y, 1, packed.data(), w.out);
    for (std::size_t x = 0; x < packed.size(); ++x)
        for (std::size_t b = 0; b < 4; ++b)
            w.row[4 * x + b] = static_cast<png_byte>(packed[x] >> (8 * b) & 0xFF);
}

// False when libpng gave up; writer.error then says why.
bool write_all(Writer& w) {
    if (setjmp(png_jmpbuf(w.png)) != 0) return false;
    png_set_write_fn(w.png, &w, on_write, on_flush);
    png_set_compression_level(w.png, kDeflateLevel);
    png_set_compression_strategy(w.png, kStrategy);
    png_set_filter(w.png, PNG_FILTER_TYPE_BASE, kFilter);
    png_set_IHDR(w.png, w.info, static_cast<png_uint_32>(w.table.width),
                 static_cast<png_uint_32>(w.table.height), w.bit_depth, w.colour_type,
                 PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_gAMA_fixed(w.png, w.info, 100000);  // 1.0: the codes are linear
    png_set_text(w.png, w.info, w.texts.data(), static_cast<int>(w.texts.size()));
    png_write_info(w.png, w.info);
    for (std::size_t y = 0; y < w.table.height; ++y) {
        if (y % kLinesBetween == 0) w.between_lines();  // may throw: no C frame is open here
        if (w.packed)
            fill_packed_row(w, y);
        else
            fill_row(w, y);
        png_write_row(w.png, w.row.data());
    }
    png_write_end(w.png, nullptr);
    return true;
}

std::vector<png_text> texts_of(Metadata& metadata) {
    std::vector<png_text> texts;
    for (auto& [key, value] : metadata) {
        png_text text{};
        text.compression = PNG_TEXT_COMPRESSION_NONE;
        text.key = key.data();
        text.text = value.data();
        text.text_length = value.size();
        texts.push_back(text);
    }
    return texts;
}

}  // namespace

Encoded encode_png(const Table& table, PixelType pixel, const Metadata& metadata,
                   const std::function<void()>& between_lines) {
    const bool packed = pixel == PixelType::rgb9e5;
    if (!packed && pixel != PixelType::uint8 && pixel != PixelType::uint16)
        throw Error("cannot_encode", "PNG holds uint8 or uint16, no floating point");
    const std::size_t channels = table.planes.size();
    if (channels > 4)
        throw Error("cannot_encode", "PNG holds at most four channels, the table has " +
                                         std::to_string(channels) + "; EXR holds them all");
    const int bit_depth = pixel == PixelType::uint16 ? 16 : 8;
    const int colour_type = channels == 1             ? PNG_COLOR_TYPE_GRAY
                            : channels == 4 || packed ? PNG_COLOR_TYPE_RGB_ALPHA
                                                      : PNG_COLOR_TYPE_RGB;
    const std::size_t file_channels = packed ? 4 : channels == 2 ? 3 : channels;
    Metadata texts = metadata;
    if (channels == 2) texts.emplace_back("kiln.unused_channel", "B is 0 and carries no quantity");

    Encoded result;
    result.extension = "png";
    result.quantisation_max.assign(channels, 0.0);
    result.clamped.assign(channels, 0);
    const std::size_t row_bytes =
        table.width * file_channels * static_cast<std::size_t>(bit_depth / 8);
    Writer writer{.table = table,
                  .out = result,
                  .bit_depth = bit_depth,
                  .colour_type = colour_type,
                  .file_channels = file_channels,
                  .packed = packed,
                  .row = std::vector<png_byte>(row_bytes, 0),
                  .texts = texts_of(texts),
                  .between_lines = between_lines,
                  .error = {},
                  .thrown = nullptr};
    writer.png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &writer, on_error, on_warning);
    if (writer.png != nullptr) writer.info = png_create_info_struct(writer.png);
    if (writer.info == nullptr) throw std::bad_alloc();
    if (!write_all(writer)) {
        if (writer.thrown) std::rethrow_exception(writer.thrown);
        throw Error("cannot_encode", "libpng: " + writer.error);
    }
    return result;
}

}  // namespace kiln::codec
