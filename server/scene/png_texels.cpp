// SPDX-License-Identifier: Apache-2.0
#include <png.h>

#include <algorithm>
#include <vector>

#include "server/base/png_input.h"
#include "server/scene/bounds.h"
#include "server/scene/texels.h"

namespace kiln {

namespace {

struct Reader {
    explicit Reader(std::string_view bytes) : in(bytes) {}
    std::vector<png_byte> row;
    png_uint_32 width = 0, height = 0;
    bool wide = false;
    Texels texels;
    PngInput in;
    png_structp png = in.png;
    png_infop info = in.info;
};

bool read_header(Reader& r) {
    if (setjmp(png_jmpbuf(r.png)) != 0) return false;
    png_set_user_limits(r.png, static_cast<png_uint_32>(kImageTexelsMax),
                        static_cast<png_uint_32>(kImageTexelsMax));
    png_set_chunk_cache_max(r.png, 16);
    png_set_chunk_malloc_max(r.png, 1U << 20U);
    // Text and colour profiles are not needed; unread, they cannot inflate.
    png_set_keep_unknown_chunks(r.png, PNG_HANDLE_CHUNK_NEVER, nullptr, -1);
    png_read_info(r.png, r.info);
    r.width = png_get_image_width(r.png, r.info);
    r.height = png_get_image_height(r.png, r.info);
    return true;
}

/// Every row as R G B A, 8 or 16 bits.
bool prepare(Reader& r) {
    if (setjmp(png_jmpbuf(r.png)) != 0) return false;
    if (png_get_interlace_type(r.png, r.info) != PNG_INTERLACE_NONE)
        png_error(r.png, "it is interlaced, which is not read");
    r.wide = png_get_bit_depth(r.png, r.info) == 16;
    png_set_expand(r.png);
    png_set_gray_to_rgb(r.png);
    png_set_add_alpha(r.png, 0xFFFF, PNG_FILLER_AFTER);
    png_read_update_info(r.png, r.info);
    return true;
}

void take_row(Reader& r) {
    const double code_max = r.wide ? 65535.0 : 255.0;
    std::array<unsigned, 4> lo{65535, 65535, 65535, 65535}, hi{};
    for (std::size_t i = 0; i < std::size_t{4} * r.width; ++i) {
        const unsigned code =
            r.wide ? (unsigned{r.row[2 * i]} << 8U | r.row[2 * i + 1]) : unsigned{r.row[i]};
        lo[i % 4] = std::min(lo[i % 4], code);
        hi[i % 4] = std::max(hi[i % 4], code);
    }
    for (std::size_t c = 0; c < 4; ++c) {
        r.texels.lo[c] = std::min(r.texels.lo[c], lo[c] / code_max);
        r.texels.hi[c] = std::max(r.texels.hi[c], hi[c] / code_max);
    }
}

bool read_rows(Reader& r) {
    if (setjmp(png_jmpbuf(r.png)) != 0) return false;
    for (png_uint_32 y = 0; y < r.height; ++y) {
        png_read_row(r.png, r.row.data(), nullptr);
        take_row(r);
    }
    return true;
}

}  // namespace

ImageLook look_at_png(std::string_view bytes, std::uint64_t& texels_left) {
    Reader reader(bytes);
    const auto refused = [&] {
        return ImageLook{{}, "is a PNG that cannot be read: " + reader.in.error};
    };
    if (!read_header(reader)) return refused();
    if (std::string why = refuse_size(reader.width, reader.height, texels_left); !why.empty())
        return {{}, std::move(why)};
    if (!prepare(reader)) return refused();
    reader.row.resize(std::size_t{reader.width} * 4 * (reader.wide ? 2 : 1));
    if (!read_rows(reader)) return refused();
    return {reader.texels, ""};
}

}  // namespace kiln
