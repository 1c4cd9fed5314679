// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "server/spec/job_spec.h"

namespace kiln {

/// Where the bits of measured reflectance lie in an image of this type, in words, ASCII.
std::string pixel_words(ImageFormat format, PixelType pixel, Kind kind = Kind::slices);

}  // namespace kiln
