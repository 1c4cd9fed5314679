// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cairo.h>

#include <string>

#include "server/study/study.h"

/// What the drawing files of this room share; nobody outside includes this.
namespace kiln::charts {

struct Colour {
    double r, g, b;
};
inline constexpr Colour kInk{0.13, 0.15, 0.19}, kFaint{0.88, 0.89, 0.91}, kPaper{1, 1, 1},
    kMuted{0.42, 0.45, 0.5}, kGood{0.10, 0.50, 0.30}, kBad{0.78, 0.16, 0.16};

struct Box {
    double x, y, width, height;
};

enum class Align { left, centre, right };

void set(cairo_t* to, Colour colour);
double text_width(cairo_t* to, const std::string& text, double size);
/// y is the base line.
void text(cairo_t* to, double x, double y, const std::string& words, double size,
          Align align = Align::left, Colour colour = kInk, bool bold = false);

inline constexpr double kLetters = 11;
void upright_text(cairo_t* to, double x, double y, const std::string& words);
std::string power_of_ten(int exponent);

double height_of(const LineChart& chart);
void draw(cairo_t* to, const LineChart& chart, Box box);

/// Height that a chart wants at a width of `width`, in points.
double height_of(const Chart& chart, double width);
void draw(cairo_t* to, const Chart& chart, Box box);

}  // namespace kiln::charts
