// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <string>
#include <string_view>

// Of png.h, which stays out of headers.
struct png_struct_def;
struct png_info_def;

namespace kiln {

/// libpng reading from memory. Its errors are longjmps to png_jmpbuf(png), which leave `error`:
/// what must outlive them stands beside this, outside the functions that call setjmp.
class PngInput {
  public:
    /// `bytes` outlive it.
    explicit PngInput(std::string_view bytes);
    ~PngInput();
    PngInput(const PngInput&) = delete;
    PngInput& operator=(const PngInput&) = delete;

    /// The next `count` bytes; false past the end.
    bool take(unsigned char* data, std::size_t count);

    png_struct_def* png = nullptr;
    png_info_def* info = nullptr;
    std::string error;

  private:
    std::string_view bytes_;
};

}  // namespace kiln
