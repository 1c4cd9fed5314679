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
        throw Error("cannot_draw",
                    std::string("the diagrams cannot be drawn: ") + cairo_status_to_string(status));
}

cairo_status_t append(void* to, const unsigned char* bytes, unsigned length) {
    static_cast<std::string*>(to)->append(reinterpret_cast<const char*>(bytes), length);
    return CAIRO_STATUS_SUCCESS;
}

/// Lines of a text that fit a width at a size.
std::vector<std::string> wrapped(const std::string& words, double width, double size) {
    const Surface paper(cairo_image_surface_create(CAIRO_FORMAT_A8, 1, 1));
    const std::unique_ptr<cairo_t, Freed> ruler(cairo_create(paper.get()));
    std::vector<std::string> lines(1);
    std::size_t at = 0;
    while (at < words.size()) {
        const std::size_t end = std::min(words.find(' ', at), words.size());
        const std::string longer =
            lines.back() + (lines.back().empty() ? "" : " ") + words.substr(at, end - at);
        if (!lines.back().empty() && charts::text_width(ruler.get(), longer, size) > width)
            lines.push_back(words.substr(at, end - at));
        else
            lines.back() = longer;
        at = end + 1;
    }
    return lines;
}

/// A line of text below the charts, with the answer before it where it is a verdict's first.
struct Word {
    std::string answer;
    charts::Colour colour = charts::kInk;
    std::string line;
};

/// Two charts a row, wide heat maps, furnaces and lines that are left over one; verdicts and notes
/// below.
class Sheet {
  public:
    explicit Sheet(const Study& study) : study_(study) {
        width_ = 2 * kMargin + (study.charts.size() > 1 ? 2 : 1) * kChartWidth;
        if (study.charts.size() == 1 && !wide(study.charts[0])) width_ = 2 * kMargin + kChartWidth;
        double y = kHead, row_height = 0;
        bool half = false;
        for (std::size_t i = 0; i < study.charts.size(); ++i) {
            const Chart& chart = study.charts[i];
            const bool alone = !half && (i + 1 == study.charts.size() || wide(study.charts[i + 1]));
            const bool whole = wide(chart) || width_ < 2 * kChartWidth ||
                               (alone && std::holds_alternative<LineChart>(chart));
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
        collect_words();
        height_ = words_top_ + kLine * static_cast<double>(words_.size()) + kMargin;
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
        for (const Word& word : words_) {
            const bool note = word.answer == kNote;
            if (!note)
                charts::text(to, kMargin + 12, y, word.answer, 12, charts::Align::left, word.colour,
                             true);
            charts::text(to, kMargin + (note ? 12 : 48), y, word.line, 12, charts::Align::left,
                         note ? charts::kMuted : charts::kInk);
            y += kLine;
        }
    }

  private:
    static constexpr const char* kNote = "note";

    void collect_words() {
        const double room = width_ - 2 * kMargin - 60;
        for (const Verdict& v : study_.verdicts) {
            const auto colour = v.holds      ? charts::kGood
                                : v.expected ? charts::kBad
                                             : charts::kMuted;
            std::string answer = v.holds ? "yes" : "no";
            for (const std::string& line : wrapped(v.name + ": " + v.words, room, 12)) {
                words_.push_back({answer, colour, line});
                answer.clear();
            }
        }
        for (const std::string& note : study_.notes)
            for (const std::string& line : wrapped(note, room, 12))
                words_.push_back({kNote, charts::kMuted, line});
    }

    /// Heat maps of so few columns are read at half the width as well.
    static constexpr std::size_t kHalfColumns = 32;
    static bool wide(const Chart& chart) {
        if (const auto* map = std::get_if<HeatMap>(&chart))
            return map->columns.size() > kHalfColumns;
        return !std::holds_alternative<LineChart>(chart);
    }

    const Study& study_;
    std::vector<Box> places_;
    std::vector<Word> words_;
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
