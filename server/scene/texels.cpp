// SPDX-License-Identifier: Apache-2.0
#include "server/scene/texels.h"

#include <cmath>

#include "server/scene/bounds.h"

namespace kiln {

ImageLook look_at_image(std::string_view bytes, std::uint64_t& texels_left) {
    if (bytes.starts_with("\x89PNG\r\n\x1A\n")) return look_at_png(bytes, texels_left);
    if (bytes.starts_with("\xFF\xD8\xFF")) return look_at_jpeg(bytes, texels_left);
    return {{}, "is no PNG or JPEG"};
}

std::string refuse_size(std::uint64_t width, std::uint64_t height, std::uint64_t& texels_left) {
    // Both sides are at most 2^31: no overflow.
    const std::uint64_t texels = width * height;
    if (texels == 0) return "has no texels";
    const std::string size = "has " + std::to_string(width) + " x " + std::to_string(height);
    if (texels > kImageTexelsMax)
        return size + " texels; at most " + std::to_string(kImageTexelsMax) + " are looked into";
    if (texels > texels_left)
        return "comes after " + std::to_string(kSceneTexelsMax) +
               " texels, beyond which no image of a scene is looked into";
    texels_left -= texels;
    return "";
}

double linear_from_srgb(double code) {
    return code <= 0.04045 ? code / 12.92 : std::pow((code + 0.055) / 1.055, 2.4);
}

}  // namespace kiln
