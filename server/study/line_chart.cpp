// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <string_view>
#include <utility>

#include "server/study/charts.h"

namespace kiln::charts {

namespace {

// Okabe, Ito 2008: told apart by colour-blind eyes too.
constexpr std::array<Colour, 8> kLines{{{0.00, 0.45, 0.70},
                                        {0.84, 0.37, 0.00},
                                        {0.00, 0.62, 0.45},
                                        {0.80, 0.47, 0.65},
                                        {0.34, 0.71, 0.91},
                                        {0.90, 0.62, 0.00},
                                        {0.35, 0.35, 0.35},
                                        {0.60, 0.40, 0.20}}};

struct Look {
    Colour colour;
    bool dashed = false;
};

/// What a curve stands for has its colour in every chart of every run: that of the name up to its
/// comma, dashed on OpenCL. Other names take colours in turn.
Look look_of(const Series& series, std::size_t turn) {
    constexpr std::pair<std::string_view, std::size_t> known[] = {
        {"sobol_owen", 0}, {"lattice", 1}, {"random", 2}, {"hammersley", 3}, {"quadrature", 4},
        {"cmgen", 5},      {"vndf", 0},    {"cosine", 2}, {"uniform", 1},    {"ndf", 3}};
    const std::string_view name = series.name;
    const bool dashed = name.find(", OpenCL") != name.npos;
    for (const auto& [word, colour] : known)
        if (name.substr(0, name.find(',')) == word) return {kLines[colour], dashed};
    return {kLines[turn % kLines.size()], dashed};
}

void set_dashes(cairo_t* to, bool dashed) {
    constexpr double pattern[] = {5, 3};
    cairo_set_dash(to, pattern, dashed ? 2 : 0, 0);
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
            // A tenth of the values at least, so that labels of three digits differ.
            const double span = high_ - low_;
            const double least = 0.1 * std::max(std::abs(low_), std::abs(high_));
            double margin = std::max(0.05 * span, (least - span) / 2);
            if (margin == 0) margin = 1;
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

void draw_series(cairo_t* to, const Series& series, const Scale& x, const Scale& y, Look look) {
    set(to, look.colour);
    cairo_set_line_width(to, 1);
    for (std::size_t i = 0; i < series.low.size(); ++i)
        if (x.holds(series.low[i]) && x.holds(series.high[i]) && y.holds(series.y[i]))
            line(to, x.at(series.low[i]), y.at(series.y[i]), x.at(series.high[i]),
                 y.at(series.y[i]));
    cairo_set_line_width(to, 1.8);
    set_dashes(to, look.dashed);
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
    set_dashes(to, false);
    for (std::size_t i = 0; i < series.x.size(); ++i) {
        if (!x.holds(series.x[i]) || !y.holds(series.y[i])) continue;
        cairo_arc(to, x.at(series.x[i]), y.at(series.y[i]), 2.6, 0, 2 * std::numbers::pi);
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
constexpr double kAboveLegend = 372, kBelow = 24;

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
        const Look look = look_of(chart.series[i], i);
        set(to, look.colour);
        cairo_set_line_width(to, 2.2);
        set_dashes(to, look.dashed);
        line(to, x, y - 4, x + 18, y - 4);
        set_dashes(to, false);
        text(to, x + 24, y, chart.series[i].name, kLetters);
    }
}

}  // namespace

double height_of(const LineChart& chart) { return kAboveLegend + legend_height(chart) + kBelow; }

void draw(cairo_t* to, const LineChart& chart, Box box) {
    const Box plot{box.x + 62, box.y + 30, box.width - 74,
                   box.height - 30 - 44 - legend_height(chart) - kBelow};
    Scale x(chart.log_x, plot.x, plot.x + plot.width);
    Scale y(chart.log_y, plot.y + plot.height, plot.y);
    for (const Series& series : chart.series) {
        for (const auto* values : {&series.x, &series.low, &series.high})
            for (const double value : *values) x.include(value);
        for (const double value : series.y) y.include(value);
    }
    if (chart.level) y.include(*chart.level);
    x.settle();
    y.settle();
    draw_axes(to, chart, plot, x, y);
    if (chart.level) {
        set(to, kInk);
        cairo_set_line_width(to, 1.4);
        line(to, plot.x, y.at(*chart.level), plot.x + plot.width, y.at(*chart.level));
    }
    for (std::size_t i = 0; i < chart.series.size(); ++i)
        draw_series(to, chart.series[i], x, y, look_of(chart.series[i], i));
    set(to, kInk);
    cairo_set_line_width(to, 1);
    cairo_rectangle(to, plot.x, plot.y, plot.width, plot.height);
    cairo_stroke(to);
    draw_legend(
        to, chart,
        {plot.x, plot.y + plot.height + 44 + kLegendLine, plot.width, legend_height(chart)});
}

}  // namespace kiln::charts
