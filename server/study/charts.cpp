// SPDX-License-Identifier: Apache-2.0
#include "server/study/charts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numbers>

namespace kiln::charts {

namespace {

/// From dark blue to yellow: brightness rises evenly, so that it reads in grey too.
Colour heat(double t) {
    constexpr std::array<Colour, 5> stops{{{0.27, 0.00, 0.33},
                                           {0.23, 0.32, 0.55},
                                           {0.13, 0.57, 0.55},
                                           {0.37, 0.79, 0.38},
                                           {0.99, 0.91, 0.14}}};
    const double at = std::clamp(t, 0.0, 1.0) * 4;
    const auto below = std::min<std::size_t>(3, static_cast<std::size_t>(at));
    const double f = at - static_cast<double>(below);
    const Colour a = stops[below], b = stops[below + 1];
    return {a.r + f * (b.r - a.r), a.g + f * (b.g - a.g), a.b + f * (b.b - a.b)};
}

constexpr double kCellHeight = 14;

Box heat_plot(cairo_t* to, const HeatMap& map, Box box) {
    double label = 30;
    for (const std::string& row : map.rows) label = std::max(label, text_width(to, row, 10) + 24);
    return {box.x + label, box.y + 30, box.width - label - 90,
            kCellHeight * static_cast<double>(map.rows.size())};
}

void draw_key(cairo_t* to, const HeatMap& map, Box plot) {
    const double x = plot.x + plot.width + 14, height = std::min(plot.height, 180.0);
    for (int i = 0; i < 60; ++i) {
        set(to, heat(1 - i / 59.0));
        cairo_rectangle(to, x, plot.y + i * height / 60, 12, height / 60 + 0.5);
        cairo_fill(to);
    }
    const double low = std::log10(map.low), high = std::log10(map.high);
    const int step = static_cast<int>(std::ceil(12 * (high - low) / height));
    for (int e = static_cast<int>(std::ceil(low)); e <= high; e += step)
        text(to, x + 17, plot.y + height * (high - e) / (high - low) + 4, power_of_ten(e), 10,
             Align::left, kMuted);
    text(to, x, plot.y - 8, map.value_label, 10, Align::left, kMuted);
}

void draw_cells(cairo_t* to, const HeatMap& map, Box plot) {
    const double width = plot.width / static_cast<double>(map.columns.size());
    for (std::size_t i = 0; i < map.values.size(); ++i) {
        const auto column = static_cast<double>(i % map.columns.size());
        const auto row = static_cast<double>(i / map.columns.size());
        const double value = map.values[i];
        if (std::isnan(value)) {
            set(to, kFaint);
        } else {
            const double least = std::max(std::abs(value), map.low);
            set(to, heat(std::log(least / map.low) / std::log(map.high / map.low)));
        }
        cairo_rectangle(to, plot.x + column * width, plot.y + row * kCellHeight, width - 0.5,
                        kCellHeight - 0.5);
        cairo_fill(to);
        if (map.marked.empty() || !map.marked[i]) continue;
        set(to, kBad);
        cairo_set_line_width(to, 1.6);
        cairo_rectangle(to, plot.x + column * width + 1, plot.y + row * kCellHeight + 1,
                        width - 2.5, kCellHeight - 2.5);
        cairo_stroke(to);
    }
}

double column_label_height(const HeatMap& map) {
    std::size_t longest = 0;
    for (const std::string& column : map.columns) longest = std::max(longest, column.size());
    return 8 + 6.2 * static_cast<double>(longest);
}

void draw(cairo_t* to, const HeatMap& map, Box box) {
    const Box plot = heat_plot(to, map, box);
    draw_cells(to, map, plot);
    for (std::size_t r = 0; r < map.rows.size(); ++r)
        text(to, plot.x - 6, plot.y + (static_cast<double>(r) + 0.75) * kCellHeight, map.rows[r],
             10, Align::right, kMuted);
    const double width = plot.width / static_cast<double>(map.columns.size());
    for (std::size_t c = 0; c < map.columns.size(); ++c) {
        cairo_save(to);
        cairo_translate(to, plot.x + (static_cast<double>(c) + 0.5) * width + 3,
                        plot.y + plot.height + 6);
        cairo_rotate(to, -std::numbers::pi / 2);
        text(to, 0, 0, map.columns[c], 10, Align::right, kMuted);
        cairo_restore(to);
    }
    text(to, plot.x + plot.width / 2, plot.y + plot.height + column_label_height(map) + 14,
         map.x_label, kLetters, Align::centre, kMuted);
    upright_text(to, box.x + 9, plot.y + plot.height / 2, map.y_label);
    draw_key(to, map, plot);
}

/// IEC 61966-2-1.
unsigned encoded(double linear) {
    const double v = std::clamp(linear, 0.0, 1.0);
    const double e = v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1 / 2.4) - 0.055;
    return static_cast<unsigned>(e * 255 + 0.5);
}

// The furnace's own brightness: half of white, so that what is brighter than it can be seen.
constexpr double kFurnaceLight = 0.5;

unsigned pixel(const std::array<double, 3>& value) {
    return encoded(value[0] * kFurnaceLight) << 16 | encoded(value[1] * kFurnaceLight) << 8 |
           encoded(value[2] * kFurnaceLight);
}

std::array<double, 3> at_NoV(const FurnaceBall& ball, double NoV) {
    const auto count = static_cast<double>(ball.by_NoV.size());
    const double at = std::clamp(NoV * count - 0.5, 0.0, count - 1);
    const auto below = static_cast<std::size_t>(at);
    const std::size_t above = std::min(below + 1, ball.by_NoV.size() - 1);
    std::array<double, 3> value{};
    for (std::size_t c = 0; c < 3; ++c)
        value[c] = ball.by_NoV[below][c] + (at - static_cast<double>(below)) *
                                               (ball.by_NoV[above][c] - ball.by_NoV[below][c]);
    return value;
}

constexpr double kBall = 150, kBallGap = 24;

void draw_ball(cairo_t* to, const FurnaceBall& ball, double x, double y) {
    constexpr int side = 2 * static_cast<int>(kBall), samples = 3;
    const std::unique_ptr<cairo_surface_t, decltype(&cairo_surface_destroy)> surface(
        cairo_image_surface_create(CAIRO_FORMAT_RGB24, side, side), cairo_surface_destroy);
    unsigned char* bytes = cairo_image_surface_get_data(surface.get());
    if (bytes == nullptr) return;  // the sheet's own status says why
    const int stride = cairo_image_surface_get_stride(surface.get());
    for (int row = 0; row < side; ++row)
        for (int column = 0; column < side; ++column) {
            std::array<double, 3> sum{};
            for (int s = 0; s < samples * samples; ++s) {
                const double px = (column + (s % samples + 0.5) / samples) * 2 / side - 1;
                const double py = (row + (s / samples + 0.5) / samples) * 2 / side - 1;
                const double r2 = (px * px + py * py) * 1.08 * 1.08;
                const std::array<double, 3> white{1, 1, 1};
                const auto value = r2 < 1 ? at_NoV(ball, std::sqrt(1 - r2)) : white;
                for (std::size_t c = 0; c < 3; ++c) sum[c] += value[c] / (samples * samples);
            }
            reinterpret_cast<unsigned*>(bytes + static_cast<std::ptrdiff_t>(row) * stride)[column] =
                pixel(sum);
        }
    cairo_surface_mark_dirty(surface.get());
    cairo_save(to);
    cairo_translate(to, x, y);
    cairo_scale(to, 0.5, 0.5);
    cairo_set_source_surface(to, surface.get(), 0, 0);
    cairo_paint(to);
    cairo_restore(to);
}

void draw(cairo_t* to, const FurnaceBalls& chart, Box box) {
    double x = box.x + 12, y = box.y + 30;
    for (const FurnaceBall& ball : chart.balls) {
        if (x + kBall > box.x + box.width) {
            x = box.x + 12;
            y += kBall + 40;
        }
        draw_ball(to, ball, x, y);
        text(to, x + kBall / 2, y + kBall + 16, ball.caption, kLetters, Align::centre, kMuted);
        x += kBall + kBallGap;
    }
}

double height_at(const LineChart& chart, double) { return height_of(chart); }
double height_at(const HeatMap& map, double) {
    return 30 + kCellHeight * static_cast<double>(map.rows.size()) + column_label_height(map) + 34;
}
double height_at(const FurnaceBalls& chart, double width) {
    const auto a_row = std::max(1.0, std::floor((width - 12 + kBallGap) / (kBall + kBallGap)));
    return 30 + (kBall + 40) * std::ceil(static_cast<double>(chart.balls.size()) / a_row);
}

}  // namespace

void set(cairo_t* to, Colour colour) { cairo_set_source_rgb(to, colour.r, colour.g, colour.b); }

double text_width(cairo_t* to, const std::string& words, double size) {
    cairo_select_font_face(to, "DejaVu Sans", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
    cairo_set_font_size(to, size);
    cairo_text_extents_t extents;
    cairo_text_extents(to, words.c_str(), &extents);
    return extents.x_advance;
}

void text(cairo_t* to, double x, double y, const std::string& words, double size, Align align,
          Colour colour, bool bold) {
    cairo_select_font_face(to, "DejaVu Sans", CAIRO_FONT_SLANT_NORMAL,
                           bold ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL);
    cairo_set_font_size(to, size);
    cairo_text_extents_t extents;
    cairo_text_extents(to, words.c_str(), &extents);
    const double shift = align == Align::left     ? 0
                         : align == Align::centre ? extents.x_advance / 2
                                                  : extents.x_advance;
    set(to, colour);
    cairo_move_to(to, x - shift, y);
    cairo_show_text(to, words.c_str());
}

std::string power_of_ten(int exponent) {
    if (exponent == 0) return "1";
    if (exponent == 1) return "10";
    return "1e" + std::to_string(exponent);
}

void upright_text(cairo_t* to, double x, double y, const std::string& words) {
    cairo_save(to);
    cairo_translate(to, x, y);
    cairo_rotate(to, -std::numbers::pi / 2);
    text(to, 0, 0, words, kLetters, Align::centre, kMuted);
    cairo_restore(to);
}

double height_of(const Chart& chart, double width) {
    return std::visit([&](const auto& one) { return height_at(one, width); }, chart);
}

void draw(cairo_t* to, const Chart& chart, Box box) {
    std::visit(
        [&](const auto& one) {
            text(to, box.x + 12, box.y + 16, one.title, 13, Align::left, kInk, true);
            draw(to, one, box);
        },
        chart);
}

}  // namespace kiln::charts
