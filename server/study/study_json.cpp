// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdio>
#include <limits>
#include <nlohmann/json.hpp>

#include "server/study/study.h"

namespace kiln {

namespace {

using Json = nlohmann::ordered_json;

Json number(double value) {
    if (std::isfinite(value)) return value;
    return std::isnan(value) ? "nan" : value > 0 ? "inf" : "-inf";
}

double number(const Json& value) {
    if (value.is_number()) return value.get<double>();
    const auto& word = value.get_ref<const std::string&>();
    if (word == "nan") return std::numeric_limits<double>::quiet_NaN();
    if (word == "inf") return std::numeric_limits<double>::infinity();
    if (word == "-inf") return -std::numeric_limits<double>::infinity();
    throw nlohmann::detail::other_error::create(501, "no number: " + word, &value);
}

Json numbers(const std::vector<double>& values) {
    Json list = Json::array();
    for (const double value : values) list.push_back(number(value));
    return list;
}

std::vector<double> numbers(const Json& list) {
    std::vector<double> values;
    for (const Json& value : list) values.push_back(number(value));
    return values;
}

Json optional(const std::optional<double>& value) { return value ? number(*value) : Json(nullptr); }

std::optional<double> optional(const Json& value) {
    if (value.is_null()) return {};
    return number(value);
}

Json to_json(const Cell& cell) {
    if (cell.number) return number(*cell.number);
    return cell.word.empty() ? Json(nullptr) : Json(cell.word);
}

Cell cell_of(const Json& value) {
    if (value.is_null()) return {};
    if (value.is_number()) return value.get<double>();
    const auto word = value.get<std::string>();
    if (word == "nan" || word == "inf" || word == "-inf") return number(value);
    return word;
}

Json to_json(const LineChart& chart) {
    Json series = Json::array();
    for (const Series& s : chart.series)
        series.push_back({{"name", s.name},
                          {"x", numbers(s.x)},
                          {"y", numbers(s.y)},
                          {"low", numbers(s.low)},
                          {"high", numbers(s.high)}});
    return {{"chart", "lines"},         {"title", chart.title},          {"x_label", chart.x_label},
            {"y_label", chart.y_label}, {"log_x", chart.log_x},          {"log_y", chart.log_y},
            {"series", series},         {"level", optional(chart.level)}};
}

Json to_json(const HeatMap& map) {
    return {{"chart", "heat_map"},
            {"title", map.title},
            {"x_label", map.x_label},
            {"y_label", map.y_label},
            {"value_label", map.value_label},
            {"columns", map.columns},
            {"rows", map.rows},
            {"values", numbers(map.values)},
            {"low", map.low},
            {"high", map.high},
            {"marked", map.marked}};
}

Json to_json(const FurnaceBalls& chart) {
    Json balls = Json::array();
    for (const FurnaceBall& ball : chart.balls)
        balls.push_back({{"caption", ball.caption}, {"by_NoV", ball.by_NoV}});
    return {{"chart", "furnace"}, {"title", chart.title}, {"balls", balls}};
}

LineChart lines_of(const Json& json) {
    LineChart chart{json.at("title"), json.at("x_label"), json.at("y_label"),
                    json.at("log_x"), json.at("log_y"),   {}};
    for (const Json& s : json.at("series"))
        chart.series.push_back({s.at("name"), numbers(s.at("x")), numbers(s.at("y")),
                                numbers(s.at("low")), numbers(s.at("high"))});
    if (json.contains("level")) chart.level = optional(json["level"]);  // older reports have none
    return chart;
}

HeatMap heat_map_of(const Json& json) {
    return {json.at("title"),           json.at("x_label"), json.at("y_label"),
            json.at("value_label"),     json.at("columns"), json.at("rows"),
            numbers(json.at("values")), json.at("low"),     json.at("high"),
            json.at("marked")};
}

FurnaceBalls furnace_of(const Json& json) {
    FurnaceBalls chart{json.at("title"), {}};
    for (const Json& ball : json.at("balls"))
        chart.balls.push_back({ball.at("caption"), ball.at("by_NoV")});
    return chart;
}

Chart chart_of(const Json& json) {
    const std::string kind = json.at("chart");
    if (kind == "lines") return lines_of(json);
    if (kind == "heat_map") return heat_map_of(json);
    return furnace_of(json);
}

Json document(const Study& study) {
    Json verdicts = Json::array(), rows = Json::array(), charts = Json::array();
    for (const Verdict& v : study.verdicts)
        verdicts.push_back({{"name", v.name},
                            {"holds", v.holds},
                            {"expected", v.expected},
                            {"value", optional(v.value)},
                            {"bound", optional(v.bound)},
                            {"words", v.words}});
    for (const auto& row : study.table.rows) {
        Json cells = Json::array();
        for (const Cell& cell : row) cells.push_back(to_json(cell));
        rows.push_back(std::move(cells));
    }
    for (const Chart& chart : study.charts)
        charts.push_back(std::visit([](const auto& one) { return to_json(one); }, chart));
    return {{"title", study.title},
            {"notes", study.notes},
            {"verdicts", verdicts},
            {"table", {{"columns", study.table.columns}, {"rows", rows}}},
            {"charts", charts}};
}

Study study_of(const Json& json) {
    Study study{json.at("title"), json.at("notes"), {}, {}, {}};
    for (const Json& v : json.at("verdicts"))
        study.verdicts.push_back({v.at("name"), v.at("holds"), v.at("expected"),
                                  optional(v.at("value")), optional(v.at("bound")), v.at("words")});
    study.table.columns = json.at("table").at("columns");
    for (const Json& cells : json.at("table").at("rows")) {
        auto& row = study.table.rows.emplace_back();
        for (const Json& value : cells) row.push_back(cell_of(value));
    }
    for (const Json& chart : json.at("charts")) study.charts.push_back(chart_of(chart));
    return study;
}

std::string csv_field(const Cell& cell) {
    if (cell.number) {
        char text[32];
        std::snprintf(text, sizeof text, "%.17g", *cell.number);
        return text;
    }
    if (cell.word.find_first_of(",\"\r\n") == cell.word.npos) return cell.word;
    std::string quoted = "\"";
    for (const char c : cell.word) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
    return quoted + '"';
}

}  // namespace

std::string to_json(const Study& study) { return document(study).dump(); }

std::string with_study(const std::string& report, const Study& study) {
    Json whole = Json::parse(report);
    whole["study"] = document(study);
    return whole.dump();
}

std::optional<Study> study_of_report(std::string_view report) {
    try {
        const Json whole = Json::parse(report);
        if (!whole.contains("study")) return {};
        return study_of(whole["study"]);
    } catch (const Json::exception&) {
        return {};
    }
}

std::string to_csv(const StudyTable& table) {
    std::string text;
    const auto line = [&](const auto& cells) {
        for (std::size_t i = 0; i < cells.size(); ++i)
            text += (i == 0 ? "" : ",") + csv_field(Cell(cells[i]));
        text += "\r\n";
    };
    line(table.columns);
    for (const auto& row : table.rows) line(row);
    return text;
}

}  // namespace kiln
