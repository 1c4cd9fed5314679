// SPDX-License-Identifier: Apache-2.0
#include "server/study/draw.h"

#include <cairo-svg.h>

#include <algorithm>
#include <memory>

#include "server/base/error.h"
#include "server/study/charts.h"

namespace kiln {

namespace {

using charts::Box;

constexpr double kMargin = 24, kChartWidth = 560, kLine = 19, kHead = 58;
// Pixels a point: sharp on screens of today.
constexpr double kPixels = 2;

struct Freed {
    void operator()(cairo_surface_t* surface) const { cairo_surface_destroy(surface); }
    void operator()(cairo_t* drawing) const { cairo_destroy(drawing); }
};
using Surface = std::unique_ptr<cairo_surface_t, Freed>;

void check(cairo_status_t status) {
    if (status != CAIRO_STATUS_SUCCESS)
        throw Error("cannot_draw", std::string("the diagrams cannot be drawn: ") +
                                       cairo_status_to_string(status));
}

cairo_status_t append(void* to, const unsigned char* bytes, unsigned length) {
    static_cast<std::string*>(to)->append(reinterpret_cast<const char*>(bytes), length);
    return CAIRO_STATUS_SUCCESS;
}

/// Two charts a row, heat maps and furnaces one; verdicts and notes below.
class Sheet {
  public:
    explicit Sheet(const Study& study) : study_(study) {
        width_ = 2 * kMargin + (study.charts.size() > 1 ? 2 : 1) * kChartWidth;
        if (study.charts.size() == 1 && !wide(study.charts[0])) width_ = 2 * kMargin + kChartWidth;
        double y = kHead, row_height = 0;
        bool half = false;
        for (const Chart& chart : study.charts) {
            const bool whole = wide(chart) || width_ < 2 * kChartWidth;
            if (half && whole) y += row_height, half = false;
            const double width = whole ? width_ - 2 * kMargin : kChartWidth;
            const double height = charts::height_of(chart, width);
            places_.push_back({kMargin + (half ? kChartWidth : 0), y, width, height});
            row_height = half ? std::max(row_height, height) : height;
            if (whole || half) y += row_height;
            half = !whole && !half;
        }
        if (half) y += row_height;
        words_top_ = y + kLine;
        height_ = words_top_ +
                  kLine * static_cast<double>(study.verdicts.size() + study.notes.size()) + kMargin;
    }
    double width() const { return width_; }
    double height() const { return height_; }

    void draw(cairo_t* to) const {
        charts::set(to, charts::kPaper);
        cairo_paint(to);
        charts::text(to, kMargin + 12, 36, study_.title, 18, charts::Align::left, charts::kInk,
                     true);
        for (std::size_t i = 0; i < places_.size(); ++i)
            charts::draw(to, study_.charts[i], places_[i]);
        double y = words_top_;
        for (const Verdict& verdict : study_.verdicts) {
            const auto colour = verdict.holds      ? charts::kGood
                                : verdict.expected ? charts::kBad
                                                   : charts::kMuted;
            charts::text(to, kMargin + 12, y, verdict.holds ? "yes" : "no", 12, charts::Align::left,
                         colour, true);
            charts::text(to, kMargin + 48, y, verdict.name + ": " + verdict.words, 12);
            y += kLine;
        }
        for (const std::string& note : study_.notes) {
            charts::text(to, kMargin + 12, y, note, 11, charts::Align::left, charts::kMuted);
            y += kLine;
        }
    }

  private:
    static bool wide(const Chart& chart) { return !std::holds_alternative<LineChart>(chart); }

    const Study& study_;
    std::vector<Box> places_;
    double width_ = 0, height_ = 0, words_top_ = 0;
};

void draw_on(const Sheet& sheet, const Surface& surface, double scale) {
    check(cairo_surface_status(surface.get()));
    const std::unique_ptr<cairo_t, Freed> drawing(cairo_create(surface.get()));
    cairo_scale(drawing.get(), scale, scale);
    sheet.draw(drawing.get());
    check(cairo_status(drawing.get()));
}

}  // namespace

std::string draw_png(const Study& study) {
    const Sheet sheet(study);
    const Surface surface(cairo_image_surface_create(CAIRO_FORMAT_RGB24,
                                                     static_cast<int>(sheet.width() * kPixels),
                                                     static_cast<int>(sheet.height() * kPixels)));
    draw_on(sheet, surface, kPixels);
    std::string bytes;
    check(cairo_surface_write_to_png_stream(surface.get(), append, &bytes));
    return bytes;
}

std::string draw_svg(const Study& study) {
    const Sheet sheet(study);
    std::string bytes;
    const Surface surface(
        cairo_svg_surface_create_for_stream(append, &bytes, sheet.width(), sheet.height()));
    draw_on(sheet, surface, 1);
    cairo_surface_finish(surface.get());
    check(cairo_surface_status(surface.get()));
    return bytes;
}

}  // namespace kiln
