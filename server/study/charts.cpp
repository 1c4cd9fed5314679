// SPDX-License-Identifier: Apache-2.0
#include "server/study/charts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>

namespace kiln::charts {

namespace {

constexpr double kLetters = 11;
constexpr double kPi = 3.14159265358979323846;
// Okabe, Ito 2008: told apart by colour-blind eyes too.
constexpr std::array<Colour, 8> kLines{{{0.00, 0.45, 0.70},
                                        {0.84, 0.37, 0.00},
                                        {0.00, 0.62, 0.45},
                                        {0.80, 0.47, 0.65},
                                        {0.34, 0.71, 0.91},
                                        {0.90, 0.62, 0.00},
                                        {0.35, 0.35, 0.35},
                                        {0.60, 0.40, 0.20}}};

std::string power_of_ten(int exponent) {
    if (exponent == 0) return "1";
    if (exponent == 1) return "10";
    return "1e" + std::to_string(exponent);
}

/// From data to paper, along one axis.
class Scale {
  public:
    Scale(bool log, double from, double to) : log_(log), from_(from), to_(to) {}

    void include(double value) {
        if (!std::isfinite(value) || (log_ && value <= 0)) return;
        const double at = log_ ? std::log10(value) : value;
        low_ = std::min(low_, at);
        high_ = std::max(high_, at);
    }
    /// Ends at whole decades, or a little beyond the data.
    void settle() {
        if (!(low_ <= high_)) low_ = 0, high_ = 1;
        if (log_) {
            low_ = std::floor(low_ - 0.05);
            high_ = std::ceil(high_ + 0.05);
        } else {
            const double margin = low_ == high_ ? 1 : 0.05 * (high_ - low_);
            low_ -= margin;
            high_ += margin;
        }
    }
    bool holds(double value) const { return std::isfinite(value) && (!log_ || value > 0); }
    double at(double value) const {
        const double t = ((log_ ? std::log10(value) : value) - low_) / (high_ - low_);
        return from_ + t * (to_ - from_);
    }
    std::vector<std::pair<double, std::string>> ticks() const {
        std::vector<std::pair<double, std::string>> found;
        if (log_) {
            const int step = high_ - low_ > 8 ? 2 : 1;
            for (int e = static_cast<int>(low_); e <= static_cast<int>(high_); e += step)
                found.emplace_back(std::pow(10.0, e), power_of_ten(e));
            return found;
        }
        const double raw = (high_ - low_) / 5, unit = std::pow(10.0, std::floor(std::log10(raw)));
        const double step = raw / unit < 1.5 ? unit : raw / unit < 3.5 ? 2 * unit : 5 * unit;
        for (double v = std::ceil(low_ / step) * step; v <= high_; v += step) {
            char label[32];
            std::snprintf(label, sizeof label, "%.3g", std::abs(v) < step / 2 ? 0.0 : v);
            found.emplace_back(v, label);
        }
        return found;
    }

  private:
    bool log_;
    double from_, to_;
    double low_ = std::numeric_limits<double>::infinity(), high_ = -low_;
};

void line(cairo_t* to, double x0, double y0, double x1, double y1) {
    cairo_move_to(to, x0, y0);
    cairo_line_to(to, x1, y1);
    cairo_stroke(to);
}

void upright_text(cairo_t* to, double x, double y, const std::string& words) {
    cairo_save(to);
    cairo_translate(to, x, y);
    cairo_rotate(to, -kPi / 2);
    text(to, 0, 0, words, kLetters, Align::centre, kMuted);
    cairo_restore(to);
}

void draw_series(cairo_t* to, const Series& series, const Scale& x, const Scale& y, Colour colour) {
    set(to, colour);
    cairo_set_line_width(to, 1);
    for (std::size_t i = 0; i < series.low.size(); ++i)
        if (x.holds(series.low[i]) && x.holds(series.high[i]) && y.holds(series.y[i]))
            line(to, x.at(series.low[i]), y.at(series.y[i]), x.at(series.high[i]),
                 y.at(series.y[i]));
    cairo_set_line_width(to, 1.8);
    bool down = false;
    for (std::size_t i = 0; i < series.x.size(); ++i) {
        if (!x.holds(series.x[i]) || !y.holds(series.y[i])) {
            down = false;
            continue;
        }
        (down ? cairo_line_to : cairo_move_to)(to, x.at(series.x[i]), y.at(series.y[i]));
        down = true;
    }
    cairo_stroke(to);
    for (std::size_t i = 0; i < series.x.size(); ++i) {
        if (!x.holds(series.x[i]) || !y.holds(series.y[i])) continue;
        cairo_arc(to, x.at(series.x[i]), y.at(series.y[i]), 2.6, 0, 2 * kPi);
        cairo_fill(to);
    }
}

void draw_axes(cairo_t* to, const LineChart& chart, Box plot, const Scale& x, const Scale& y) {
    cairo_set_line_width(to, 1);
    for (const auto& [value, label] : x.ticks()) {
        set(to, kFaint);
        line(to, x.at(value), plot.y, x.at(value), plot.y + plot.height);
        text(to, x.at(value), plot.y + plot.height + 15, label, kLetters, Align::centre, kMuted);
    }
    for (const auto& [value, label] : y.ticks()) {
        set(to, kFaint);
        line(to, plot.x, y.at(value), plot.x + plot.width, y.at(value));
        text(to, plot.x - 6, y.at(value) + 4, label, kLetters, Align::right, kMuted);
    }
    text(to, plot.x + plot.width / 2, plot.y + plot.height + 32, chart.x_label, kLetters,
         Align::centre, kMuted);
    upright_text(to, plot.x - 48, plot.y + plot.height / 2, chart.y_label);
}

constexpr double kLegendLine = 16;

/// Names beside a short stroke, in columns below the plot.
std::size_t legend_columns(const LineChart& chart) { return chart.series.size() > 3 ? 2 : 1; }
double legend_height(const LineChart& chart) {
    const std::size_t columns = legend_columns(chart);
    return kLegendLine * static_cast<double>((chart.series.size() + columns - 1) / columns);
}

void draw_legend(cairo_t* to, const LineChart& chart, Box box) {
    const std::size_t columns = legend_columns(chart);
    const std::size_t rows = (chart.series.size() + columns - 1) / columns;
    for (std::size_t i = 0; i < chart.series.size(); ++i) {
        const double x =
            box.x + static_cast<double>(i / rows) * box.width / static_cast<double>(columns);
        const double y = box.y + kLegendLine * static_cast<double>(i % rows);
        set(to, kLines[i % kLines.size()]);
        cairo_set_line_width(to, 2.2);
        line(to, x, y - 4, x + 18, y - 4);
        text(to, x + 24, y, chart.series[i].name, kLetters);
    }
}

void draw(cairo_t* to, const LineChart& chart, Box box) {
    const Box plot{box.x + 62, box.y + 30, box.width - 74,
                   box.height - 30 - 44 - legend_height(chart) - 8};
    Scale x(chart.log_x, plot.x, plot.x + plot.width);
    Scale y(chart.log_y, plot.y + plot.height, plot.y);
    for (const Series& series : chart.series) {
        for (const auto* values : {&series.x, &series.low, &series.high})
            for (const double value : *values) x.include(value);
        for (const double value : series.y) y.include(value);
    }
    x.settle();
    y.settle();
    draw_axes(to, chart, plot, x, y);
    for (std::size_t i = 0; i < chart.series.size(); ++i)
        draw_series(to, chart.series[i], x, y, kLines[i % kLines.size()]);
    set(to, kInk);
    cairo_set_line_width(to, 1);
    cairo_rectangle(to, plot.x, plot.y, plot.width, plot.height);
    cairo_stroke(to);
    draw_legend(
        to, chart,
        {plot.x, plot.y + plot.height + 44 + kLegendLine, plot.width, legend_height(chart)});
}

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
    const int step = high - low > 8 ? 3 : 1;
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
        cairo_rotate(to, -kPi / 2);
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

double height_at(const LineChart& chart, double) { return 380 + legend_height(chart); }
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
