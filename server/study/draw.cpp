// SPDX-License-Identifier: Apache-2.0
#include "server/study/draw.h"

#include <cairo-svg.h>

#include <algorithm>
#include <array>
#include <memory>

#include "server/base/error.h"
#include "server/study/charts.h"

namespace kiln {

namespace {

using charts::Box;

constexpr double kMargin = 24, kChartWidth = 560, kLine = 19, kHead = 58;
constexpr double kAnswerWidth = 58;  // "known" in bold, and a gap
// Pixels a point: sharp on screens of today.
constexpr double kPixels = 2, kPixelsPacked = 1.5;

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

/// Two charts a row, wide heat maps, furnaces and lines that are left over one; of what that makes
/// too tall, four columns packed from the top. Verdicts and notes below.
class Sheet {
  public:
    explicit Sheet(const Study& study) : study_(study) {
        words_top_ = place_in_rows() + kLine;
        if (words_top_ > kTall) {
            words_top_ = pack() + kLine;
            pixels_ = kPixelsPacked;
        }
        collect_words();
        height_ = words_top_ + kLine * static_cast<double>(words_.size()) + kMargin;
    }
    double pixels() const { return pixels_; }
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
            charts::text(to, kMargin + 12 + (note ? 0 : kAnswerWidth), y, word.line, 12,
                         charts::Align::left, note ? charts::kMuted : charts::kInk);
            y += kLine;
        }
    }

  private:
    static constexpr const char* kNote = "note";
    static constexpr std::size_t kColumns = 4;
    static constexpr double kTall = 1300;

    /// The lower end of the charts.
    double place_in_rows() {
        const std::vector<Chart>& all = study_.charts;
        width_ = 2 * kMargin + (all.size() > 1 ? 2 : 1) * kChartWidth;
        if (all.size() == 1 && !wide(all[0])) width_ = 2 * kMargin + kChartWidth;
        double y = kHead, row_height = 0;
        bool half = false;
        for (std::size_t i = 0; i < all.size(); ++i) {
            const Chart& chart = all[i];
            const bool alone = !half && (i + 1 == all.size() || wide(all[i + 1]));
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
        return half ? y + row_height : y;
    }

    /// Each chart where it comes to lie highest, wide ones over two columns and first.
    double pack() {
        width_ = 2 * kMargin + kColumns * kChartWidth;
        std::array<double, kColumns> ends;
        ends.fill(kHead);
        for (const std::size_t span : {2u, 1u})
            for (std::size_t i = 0; i < study_.charts.size(); ++i) {
                if ((wide(study_.charts[i]) ? 2u : 1u) != span) continue;
                const auto end_at = [&](std::size_t column) {
                    return *std::max_element(&ends[column], &ends[column] + span);
                };
                std::size_t best = 0;
                for (std::size_t c = 1; c + span <= kColumns; ++c)
                    if (end_at(c) < end_at(best)) best = c;
                const double width = static_cast<double>(span) * kChartWidth, y = end_at(best);
                const double x = kMargin + static_cast<double>(best) * kChartWidth;
                places_[i] = {x, y, width, charts::height_of(study_.charts[i], width)};
                std::fill_n(&ends[best], span, y + places_[i].height);
            }
        return *std::max_element(ends.begin(), ends.end());
    }

    /// Verdicts that hold are told by name where they are many: their words are in the other files.
    void collect_words() {
        constexpr std::size_t kMany = 16;
        const double room = width_ - 2 * kMargin - 24 - kAnswerWidth;
        std::string held;
        std::size_t count = 0;
        for (const Verdict& v : study_.verdicts) {
            if (v.holds && study_.verdicts.size() > kMany) {
                held += (held.empty() ? "" : "; ") + v.name;
                ++count;
                continue;
            }
            const auto colour = v.holds      ? charts::kGood
                                : v.expected ? charts::kBad
                                             : charts::kMuted;
            std::string answer = v.answer();
            for (const std::string& line : wrapped(v.name + ": " + v.words, room, 12)) {
                words_.push_back({answer, colour, line});
                answer.clear();
            }
        }
        if (count > 0) {
            std::string answer = "yes";
            held = std::to_string(count) + " verdicts: " + held;
            for (const std::string& line : wrapped(held, room, 12)) {
                words_.push_back({answer, charts::kGood, line});
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
    double width_ = 0, height_ = 0, words_top_ = 0, pixels_ = kPixels;
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
    const Surface surface(cairo_image_surface_create(
        CAIRO_FORMAT_RGB24, static_cast<int>(sheet.width() * sheet.pixels()),
        static_cast<int>(sheet.height() * sheet.pixels())));
    draw_on(sheet, surface, sheet.pixels());
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
