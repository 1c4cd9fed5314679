// SPDX-License-Identifier: Apache-2.0
#include "server/base/png_input.h"

#include <png.h>

#include <cstring>
#include <new>

namespace kiln {

namespace {

[[noreturn]] void on_error(png_structp png, png_const_charp message) {
    static_cast<PngInput*>(png_get_error_ptr(png))->error = message;
    png_longjmp(png, 1);
}

void on_warning(png_structp, png_const_charp) {}

void on_read(png_structp png, png_bytep data, png_size_t count) {
    if (!static_cast<PngInput*>(png_get_io_ptr(png))->take(data, count))
        png_error(png, "it is cut short");
}

}  // namespace

PngInput::PngInput(std::string_view bytes) : bytes_(bytes) {
    png = png_create_read_struct(PNG_LIBPNG_VER_STRING, this, on_error, on_warning);
    if (png != nullptr) info = png_create_info_struct(png);
    if (info == nullptr) {
        png_destroy_read_struct(&png, &info, nullptr);
        throw std::bad_alloc();
    }
    png_set_read_fn(png, this, on_read);
    // Without this a chunk above the caller's limits is warned of, and allocated all the same.
    png_set_benign_errors(png, 0);
}

PngInput::~PngInput() { png_destroy_read_struct(&png, &info, nullptr); }

bool PngInput::take(unsigned char* data, std::size_t count) {
    if (count > bytes_.size()) return false;
    std::memcpy(data, bytes_.data(), count);
    bytes_.remove_prefix(count);
    return true;
}

}  // namespace kiln
