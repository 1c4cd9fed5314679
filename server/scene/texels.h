// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace kiln {

/// Least and largest code of each channel R G B A of an image, in 0…1 as stored: no transfer
/// function is undone. What an image does not have reads as G = B = R for gray, A = 1.
struct Texels {
    std::array<double, 4> lo{1, 1, 1, 1}, hi{0, 0, 0, 0};
};

/// An image as far as it could be read.
struct ImageLook {
    std::optional<Texels> texels;
    std::string why_not;  ///< a clause: "is no PNG or JPEG", "is cut short", …
};

/// PNG or JPEG by their first bytes. `texels_left` is what may still be decoded for this scene; an
/// image above it, or above kImageTexelsMax, is not. Never throws for what the bytes hold.
ImageLook look_at_image(std::string_view bytes, std::uint64_t& texels_left);

/// Linear value of an sRGB code in 0…1 (IEC 61966-2-1).
double linear_from_srgb(double code);

// The two decoders; `bytes` starts with their signature.
ImageLook look_at_png(std::string_view bytes, std::uint64_t& texels_left);
ImageLook look_at_jpeg(std::string_view bytes, std::uint64_t& texels_left);

/// "" when an image of this size may be decoded, which is then taken off `texels_left`.
std::string refuse_size(std::uint64_t width, std::uint64_t height, std::uint64_t& texels_left);

}  // namespace kiln
