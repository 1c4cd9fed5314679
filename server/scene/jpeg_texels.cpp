// SPDX-License-Identifier: Apache-2.0
#include <csetjmp>
#include <cstddef>
#include <cstdio>
// jpeglib.h needs the two above.
#include <jpeglib.h>

#include <algorithm>
#include <vector>

#include "server/scene/bounds.h"
#include "server/scene/texels.h"

namespace kiln {

namespace {

struct Reader {
    jpeg_error_mgr errors{};  // first, so that libjpeg's pointer to it is one to this
    std::jmp_buf escape{};
    std::string error;
    jpeg_decompress_struct jpeg{};
    jpeg_progress_mgr progress{};
    std::vector<JSAMPLE> row;
    Texels texels;

    ~Reader() { jpeg_destroy_decompress(&jpeg); }
};

[[noreturn]] void on_error(j_common_ptr jpeg) {
    auto* reader = reinterpret_cast<Reader*>(jpeg->err);
    char message[JMSG_LENGTH_MAX];
    jpeg->err->format_message(jpeg, message);
    reader->error = message;
    std::longjmp(reader->escape, 1);
}

void on_message(j_common_ptr, int) {}

void on_progress(j_common_ptr jpeg) {
    const auto* decompress = reinterpret_cast<j_decompress_ptr>(jpeg);
    if (decompress->input_scan_number <= kImageScansMax) return;
    reinterpret_cast<Reader*>(jpeg->err)->error = "it has too many scans";
    std::longjmp(reinterpret_cast<Reader*>(jpeg->err)->escape, 1);
}

bool read_header(Reader& r, std::string_view bytes) {
    if (setjmp(r.escape) != 0) return false;
    jpeg_create_decompress(&r.jpeg);
    r.jpeg.mem->max_memory_to_use = static_cast<long>(kImageMemoryBytesMax);
    r.progress.progress_monitor = on_progress;
    r.jpeg.progress = &r.progress;
    jpeg_mem_src(&r.jpeg, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
    jpeg_read_header(&r.jpeg, TRUE);
    return true;
}

bool start(Reader& r) {
    if (setjmp(r.escape) != 0) return false;
    r.jpeg.out_color_space = JCS_RGB;
    jpeg_start_decompress(&r.jpeg);
    return r.jpeg.output_components == 3;
}

bool read_rows(Reader& r) {
    if (setjmp(r.escape) != 0) return false;
    JSAMPROW row = r.row.data();
    while (r.jpeg.output_scanline < r.jpeg.output_height) {
        jpeg_read_scanlines(&r.jpeg, &row, 1);
        for (std::size_t i = 0; i < r.row.size(); ++i) {
            const double code = r.row[i] / 255.0;
            r.texels.lo[i % 3] = std::min(r.texels.lo[i % 3], code);
            r.texels.hi[i % 3] = std::max(r.texels.hi[i % 3], code);
        }
    }
    jpeg_finish_decompress(&r.jpeg);
    return true;
}

}  // namespace

ImageLook look_at_jpeg(std::string_view bytes, std::uint64_t& texels_left) {
    Reader reader;
    reader.jpeg.err = jpeg_std_error(&reader.errors);
    reader.errors.error_exit = on_error;
    reader.errors.emit_message = on_message;
    const auto refused = [&] {
        return ImageLook{{}, "is a JPEG that cannot be read: " + reader.error};
    };
    if (!read_header(reader, bytes)) return refused();
    if (std::string why =
            refuse_size(reader.jpeg.image_width, reader.jpeg.image_height, texels_left);
        !why.empty())
        return {{}, std::move(why)};
    if (!start(reader)) return refused();
    reader.row.resize(std::size_t{reader.jpeg.output_width} * 3);
    if (!read_rows(reader)) return refused();
    // libjpeg goes on past damage, with warnings and made-up texels.
    if (reader.errors.num_warnings > 0) {
        reader.error = "it is damaged";
        return refused();
    }
    reader.texels.lo[3] = reader.texels.hi[3] = 1;
    return {reader.texels, ""};
}

}  // namespace kiln
