// SPDX-License-Identifier: Apache-2.0
#include "server/measured/canvas.h"

#include <cairo.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "server/base/error.h"

namespace kiln::measured {
namespace {

struct Freed {
    void operator()(cairo_surface_t* surface) const { cairo_surface_destroy(surface); }
    void operator()(cairo_t* drawing) const { cairo_destroy(drawing); }
};

cairo_status_t append(void* to, const unsigned char* bytes, unsigned length) {
    static_cast<std::string*>(to)->append(reinterpret_cast<const char*>(bytes), length);
    return CAIRO_STATUS_SUCCESS;
}

void choose(cairo_t* pen, const Colour& linear) {
    cairo_set_source_rgb(pen, srgb_code(linear[0]) / 255.0, srgb_code(linear[1]) / 255.0,
                         srgb_code(linear[2]) / 255.0);
}

void write(cairo_t* pen, const Words& words) {
    double x = words.x;
    if (words.swatch) {
        choose(pen, *words.swatch);
        cairo_rectangle(pen, x, words.y - 0.5 * words.size, 1.3 * words.size, 0.3 * words.size);
        cairo_fill_preserve(pen);
        choose(pen, words.ink);  // white materials are told from the paper by an edge
        cairo_set_line_width(pen, 0.05 * words.size);
        cairo_stroke(pen);
        x += 1.8 * words.size;
    }
    cairo_set_font_size(pen, words.size);
    choose(pen, words.ink);
    cairo_move_to(pen, x, words.y);
    cairo_show_text(pen, words.text.c_str());
}

}  // namespace

std::uint8_t srgb_code(double linear) {
    const double v = std::clamp(linear, 0.0, 1.0);
    const double code = v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1 / 2.4) - 0.055;
    return static_cast<std::uint8_t>(std::lround(255 * code));
}

std::string png_of(const Picture& picture, const std::vector<Words>& words) {
    const auto width = static_cast<int>(picture.width), height = static_cast<int>(picture.height);
    const std::unique_ptr<cairo_surface_t, Freed> surface(
        cairo_image_surface_create(CAIRO_FORMAT_RGB24, width, height));
    const auto check = [](cairo_status_t status) {
        if (status != CAIRO_STATUS_SUCCESS)
            throw Error("cannot_draw", std::string("the picture cannot be drawn: ") +
                                           cairo_status_to_string(status));
    };
    check(cairo_surface_status(surface.get()));
    unsigned char* pixels = cairo_image_surface_get_data(surface.get());
    const auto stride = static_cast<std::size_t>(cairo_image_surface_get_stride(surface.get()));
    for (std::size_t y = 0; y < picture.height; ++y)
        for (std::size_t x = 0; x < picture.width; ++x) {
            const std::uint8_t* from = picture.rgb.data() + 3 * (y * picture.width + x);
            unsigned char* to = pixels + y * stride + 4 * x;  // native order of 0x00RRGGBB
            to[0] = from[2], to[1] = from[1], to[2] = from[0];
        }
    cairo_surface_mark_dirty(surface.get());
    const std::unique_ptr<cairo_t, Freed> pen(cairo_create(surface.get()));
    cairo_select_font_face(pen.get(), "DejaVu Sans", CAIRO_FONT_SLANT_NORMAL,
                           CAIRO_FONT_WEIGHT_NORMAL);
    for (const Words& one : words) write(pen.get(), one);
    check(cairo_status(pen.get()));
    std::string bytes;
    check(cairo_surface_write_to_png_stream(surface.get(), append, &bytes));
    return bytes;
}

Canvas::Canvas(std::size_t width, std::size_t height, Colour paper)
    : width_(width * kSide), height_(height * kSide), near_(width_ * height_, -1e30f) {
    std::array<float, 3> c{};
    for (std::size_t k = 0; k < 3; ++k) c[k] = static_cast<float>(paper[k]);
    colour_.assign(width_ * height_, c);
}

void Canvas::triangle(const Point& a, const Point& b, const Point& c) {
    const double side = kSide;
    const double area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    if (std::abs(area) < 1e-12) return;
    const auto range = [&](double low, double high, std::size_t size) {
        const double most = static_cast<double>(size) - 1;
        return std::pair(static_cast<std::size_t>(std::clamp(std::floor(low * side), 0.0, most)),
                         static_cast<std::size_t>(std::clamp(std::ceil(high * side), 0.0, most)));
    };
    const auto [x0, x1] = range(std::min({a.x, b.x, c.x}), std::max({a.x, b.x, c.x}), width_);
    const auto [y0, y1] = range(std::min({a.y, b.y, c.y}), std::max({a.y, b.y, c.y}), height_);
    for (std::size_t y = y0; y <= y1; ++y)
        for (std::size_t x = x0; x <= x1; ++x) {
            const double px = (static_cast<double>(x) + 0.5) / side;
            const double py = (static_cast<double>(y) + 0.5) / side;
            const double v = ((px - a.x) * (c.y - a.y) - (py - a.y) * (c.x - a.x)) / area;
            const double w = ((b.x - a.x) * (py - a.y) - (b.y - a.y) * (px - a.x)) / area;
            const double u = 1 - v - w;
            if (u < 0 || v < 0 || w < 0) continue;
            const auto near = static_cast<float>(u * a.near + v * b.near + w * c.near);
            const std::size_t n = y * width_ + x;
            if (near <= near_[n]) continue;
            near_[n] = near;
            for (std::size_t k = 0; k < 3; ++k)
                colour_[n][k] =
                    static_cast<float>(u * a.colour[k] + v * b.colour[k] + w * c.colour[k]);
        }
}

void Canvas::line(const Point& a, const Point& b, double width, double lift) {
    const double length = std::hypot(b.x - a.x, b.y - a.y);
    if (length < 1e-9) return;
    const double nx = -(b.y - a.y) / length * width / 2, ny = (b.x - a.x) / length * width / 2;
    const auto moved = [&](const Point& p, double sign) {
        return Point{p.x + sign * nx, p.y + sign * ny, p.near + lift, p.colour};
    };
    triangle(moved(a, 1), moved(a, -1), moved(b, 1));
    triangle(moved(b, 1), moved(a, -1), moved(b, -1));
}

Picture Canvas::picture() const {
    Picture made{width_ / kSide, height_ / kSide, {}};
    made.rgb.reserve(3 * made.width * made.height);
    for (std::size_t y = 0; y < made.height; ++y)
        for (std::size_t x = 0; x < made.width; ++x)
            for (std::size_t k = 0; k < 3; ++k) {
                double sum = 0;
                for (std::size_t s = 0; s < kSide * kSide; ++s)
                    sum += static_cast<double>(
                        colour_[(y * kSide + s / kSide) * width_ + x * kSide + s % kSide][k]);
                made.rgb.push_back(srgb_code(sum / (kSide * kSide)));
            }
    return made;
}

}  // namespace kiln::measured
