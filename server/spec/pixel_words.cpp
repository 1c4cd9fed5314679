// SPDX-License-Identifier: Apache-2.0
#include "server/spec/pixel_words.h"

#include "server/spec/words.h"

namespace kiln {

std::string pixel_words(ImageFormat format, PixelType pixel, Kind kind) {
    const bool exr = format == ImageFormat::exr;
    if (pixel == PixelType::rgb9e5)
        return std::string(
                   "RGB9_E5 (EXT_texture_shared_exponent): red in bits 0-8, green 9-17, "
                   "blue 18-26, exponent 27-31; c = mantissa * 2^(exponent - 24); ") +
               (exr ? "the UINT channel RGB9E5, beside the UINT channel origin"
                    : "bits 0-7 in R, 8-15 in G, 16-23 in B, 24-31 in A: read as RGBA8 these are "
                      "the bytes of the texture");
    if (exr)
        return "R, G, B as " + std::string(to_word(pixel)) +
               (kind == Kind::companion  ? ", the extrapolated share in A"
                : kind == Kind::sampling ? ""
                                         : ", where values come from in A");
    const std::string most = pixel == PixelType::uint8 ? "255" : "65535";
    return "R, G, B linear from 0 to 1 in 0 to " + most + "; larger values are clamped";
}

}  // namespace kiln
