// SPDX-License-Identifier: Apache-2.0
#include <png.h>

#include <algorithm>
#include <string>

#include "server/base/png_input.h"
#include "server/scene/bounds.h"
#include "server/scene/texels.h"

namespace kiln {

namespace {

struct Reader {
    Reader(std::string_view given, std::uint64_t& left)
        : bytes(given), texels_left(left), in(given) {}
    std::string_view bytes;
    std::uint64_t& texels_left;
    png_uint_32 width = 0, height = 0, rows = 0;
    bool wide = false;
    Texels texels;
    std::string too_large;
    PngInput in;
    png_structp png = in.png;
    png_infop info = in.info;
};

void take_row(Reader& r, const png_byte* row) {
    const double code_max = r.wide ? 65535.0 : 255.0;
    std::array<unsigned, 4> lo{65535, 65535, 65535, 65535}, hi{};
    for (std::size_t i = 0; i < std::size_t{4} * r.width; ++i) {
        const unsigned code =
            r.wide ? (unsigned{row[2 * i]} << 8U | row[2 * i + 1]) : unsigned{row[i]};
        lo[i % 4] = std::min(lo[i % 4], code);
        hi[i % 4] = std::max(hi[i % 4], code);
    }
    for (std::size_t c = 0; c < 4; ++c) {
        r.texels.lo[c] = std::min(r.texels.lo[c], lo[c] / code_max);
        r.texels.hi[c] = std::max(r.texels.hi[c], hi[c] / code_max);
    }
}

/// Every row as R G B A, 8 or 16 bits.
void on_header(png_structp png, png_infop info) {
    Reader& r = *static_cast<Reader*>(png_get_progressive_ptr(png));
    r.width = png_get_image_width(png, info);
    r.height = png_get_image_height(png, info);
    r.too_large = refuse_size(r.width, r.height, r.texels_left);
    if (!r.too_large.empty()) png_error(png, "it is too large");
    if (png_get_interlace_type(png, info) != PNG_INTERLACE_NONE)
        png_error(png, "it is interlaced, which is not read");
    r.wide = png_get_bit_depth(png, info) == 16;
    png_set_expand(png);
    png_set_gray_to_rgb(png);
    png_set_add_alpha(png, 0xFFFF, PNG_FILLER_AFTER);
    png_read_update_info(png, info);
}

void on_row(png_structp png, png_bytep row, png_uint_32, int) {
    Reader& r = *static_cast<Reader*>(png_get_progressive_ptr(png));
    take_row(r, row);
    ++r.rows;
}

/// The progressive reader leaves what is compressed beyond the last row; the other inflates it all.
bool read(Reader& r) {
    if (setjmp(png_jmpbuf(r.png)) != 0) return false;
    png_set_progressive_read_fn(r.png, &r, on_header, on_row, nullptr);
    png_set_user_limits(r.png, static_cast<png_uint_32>(kImageTexelsMax),
                        static_cast<png_uint_32>(kImageTexelsMax));
    png_set_chunk_cache_max(r.png, 16);
    png_set_chunk_malloc_max(r.png, 1U << 20U);
    // Text and colour profiles are not needed; unread, they cannot inflate.
    png_set_keep_unknown_chunks(r.png, PNG_HANDLE_CHUNK_NEVER, nullptr, -1);
    // libpng writes to what it is given only where it decrypts, which PNG does not.
    auto* bytes = reinterpret_cast<png_bytep>(const_cast<char*>(r.bytes.data()));
    png_process_data(r.png, r.info, bytes, r.bytes.size());
    return true;
}

}  // namespace

ImageLook look_at_png(std::string_view bytes, std::uint64_t& texels_left) {
    Reader reader(bytes, texels_left);
    const bool done = read(reader);
    if (!reader.too_large.empty()) return {{}, std::move(reader.too_large)};
    if (done && reader.rows == reader.height && reader.height > 0) return {reader.texels, ""};
    return {{}, "is a PNG that cannot be read: " + (done ? "it is cut short" : reader.in.error)};
}

}  // namespace kiln
