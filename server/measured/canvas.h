// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "server/measured/material.h"

namespace kiln::measured {

/// Pixels as a screen wants them: sRGB codes, row 0 on top.
struct Picture {
    std::size_t width = 0, height = 0;
    std::vector<std::uint8_t> rgb;
};

struct Words {
    double x = 0, y = 0;  ///< pixels of the baseline's start
    std::string text;     ///< UTF-8
    double size = 13;     ///< pixels of the font
    Colour ink = {0.05, 0.05, 0.065};
    /// Of a legend: a short line of this colour before the text.
    std::optional<Colour> swatch = std::nullopt;
};
/// Throws Error("cannot_draw") naming what the drawing library says.
std::string png_of(const Picture& picture, const std::vector<Words>& words);

/// Triangles and lines with hidden surfaces removed; linear colours, several samples a pixel.
class Canvas {
  public:
    Canvas(std::size_t width, std::size_t height, Colour paper);

    struct Point {
        double x = 0, y = 0;  ///< pixels, y downwards
        double near = 0;      ///< the larger, the nearer
        Colour colour{};
    };
    void triangle(const Point& a, const Point& b, const Point& c);
    /// A line as wide as `width` pixels, `lift` nearer than its ends say.
    void line(const Point& a, const Point& b, double width, double lift);
    Picture picture() const;

  private:
    static constexpr std::size_t kSide = 3;  ///< samples along a pixel's side
    std::size_t width_, height_;             ///< samples
    std::vector<float> near_;
    std::vector<std::array<float, 3>> colour_;
};

/// IEC 61966-2-1: the code 0 … 255 of a linear value, clamped.
std::uint8_t srgb_code(double linear);

}  // namespace kiln::measured
