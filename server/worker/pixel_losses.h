// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

#include "server/compute/report.h"
#include "server/image/image.h"

namespace kiln {

/// Writes what the pixel type took into the report: each channel's quantisation, what was clamped.
void tell_pixel_losses(Report& report, const std::vector<std::string>& channels, PixelType pixel,
                       const Encoded& encoded);

}  // namespace kiln
