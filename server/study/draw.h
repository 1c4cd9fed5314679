// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "server/study/study.h"

namespace kiln {

/// The study's charts on one sheet. Throws Error("cannot_draw") naming what the drawing library
/// says.
std::string draw_png(const Study& study);
std::string draw_svg(const Study& study);

}  // namespace kiln
