// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace kiln {

/// What a study claims, with the number behind it.
struct Verdict {
    std::string name;    ///< "energy conservation"
    bool holds = false;  ///< what the name says is true of what was studied
    /// False where it is known of the model that the claim does not hold, so that nobody takes it
    /// for a defect of the program.
    bool expected = true;
    std::optional<double> value, bound;
    std::string words;  ///< one sentence, with the place of the value

    /// For people.
    const char* answer() const { return holds ? "yes" : expected ? "no" : "known"; }
};

/// A number, a word, or nothing: there is no such figure.
struct Cell {
    std::optional<double> number;
    std::string word;
    Cell() = default;
    Cell(double value) : number(value) {}
    Cell(std::string text) : word(std::move(text)) {}
};

struct StudyTable {
    std::vector<std::string> columns;
    std::vector<std::vector<Cell>> rows;  ///< as long as columns
};

/// Curves over two axes; x rises. low and high are empty or bound the spread of y's cost, in x.
struct Series {
    std::string name;
    std::vector<double> x, y, low, high;
};
struct LineChart {
    std::string title, x_label, y_label;
    bool log_x = true, log_y = true;
    std::vector<Series> series;
    std::optional<double> level{};  ///< of y, that the curves are held against
};

/// values[row * columns.size() + column], row 0 on top; NaN is a cell without a value. Colours run
/// from `low` to `high` in the logarithm.
struct HeatMap {
    std::string title, x_label, y_label, value_label;
    std::vector<std::string> columns, rows;
    std::vector<double> values;
    double low = 1e-9, high = 1;
    std::vector<bool> marked;  ///< empty, or the cells that failed
};

/// Balls in a white furnace, seen by parallel rays: a pixel's colour is the value at its NoV, which
/// lies at the centres of as many equal steps as there are values. 1 vanishes in the surroundings.
struct FurnaceBall {
    std::string caption;
    std::vector<std::array<double, 3>> by_NoV;
};
struct FurnaceBalls {
    std::string title;
    std::vector<FurnaceBall> balls;
};

using Chart = std::variant<LineChart, HeatMap, FurnaceBalls>;

/// What a study found: all that its JSON, CSV and pictures are made of.
struct Study {
    std::string title;
    std::vector<std::string> notes;  ///< one sentence each
    std::vector<Verdict> verdicts;
    StudyTable table;
    std::vector<Chart> charts;
};

/// NaN and infinity are spelled as words, since JSON has none: "nan", "inf", "-inf".
std::string to_json(const Study& study);
/// The study under "study" of a report; nothing where there is none or it is not what to_json()
/// writes.
std::optional<Study> study_of_report(std::string_view report);
/// The report's JSON with the study in it.
std::string with_study(const std::string& report, const Study& study);
/// RFC 4180, a head line first.
std::string to_csv(const StudyTable& table);

}  // namespace kiln
