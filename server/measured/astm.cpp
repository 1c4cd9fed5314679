// SPDX-License-Identifier: Apache-2.0
// ASTM E1392-96 and E2387 text: a free header, a line VARS, a row for each sample.
#include <cmath>

#include "server/base/error.h"
#include "server/measured/angles.h"
#include "server/measured/bounds.h"
#include "server/measured/readers.h"
#include "server/measured/scan_order.h"
#include "server/measured/text_scan.h"

namespace kiln::measured {
namespace {

/// The rows, each four angles and the values; all in one array.
struct Rows {
    std::vector<double> numbers;
    std::size_t width = 0;
    double angle_max = 0;
    ScanOrder order{{"theta_s", "phi_s"}};
};

/// Up to the line VARS, which stays in `line`; the count of rows that a line NUM_POINTS announces.
std::optional<double> read_header(LineScanner& lines, Line& line) {
    std::optional<double> count;
    while (true) {
        line = lines.expect("a line VARS");
        const auto [key, value] = keyed(line.text);
        if (same_word(key, "VARS")) return count;
        if (same_word(key, "NUM_POINTS")) count = parse_number(value);
    }
}

Rows read_rows(LineScanner& lines, std::size_t width) {
    Rows rows;
    rows.width = width;
    Line line;
    std::vector<double> row;
    while (lines.next(line)) {
        parse_numbers(line, row);
        if (row.size() != width)
            fail_at(line, std::to_string(row.size()) + " numbers, the line VARS names " +
                              std::to_string(width));
        if (rows.numbers.empty() || !std::equal(row.begin(), row.begin() + 2,
                                                rows.numbers.end() - static_cast<long>(width)))
            rows.order.start_section();
        rows.order.add(row[2], row[3]);
        if (rows.numbers.size() + width > kValuesMax) fail_at(line, "too many values");
        rows.numbers.insert(rows.numbers.end(), row.begin(), row.end());
        for (std::size_t a = 0; a < 4; ++a) {
            rows.angle_max = std::max(rows.angle_max, std::abs(row[a]));
            if (std::abs(row[a]) > 720) fail_at(line, "an angle of " + in_words(row[a]));
        }
    }
    return rows;
}

std::string channel_name(std::string_view word) {
    const std::string name = plain_text(word).substr(0, 32);
    if (same_word(name, "bsdf") || same_word(name, "brdf")) return "value";
    return name;
}

}  // namespace

bool is_astm(std::string_view bytes) {
    return line_starts(bytes, "VARS ", "DataBegin") || line_starts(bytes, "VARS\t", "DataBegin");
}

Reading read_astm(std::string_view bytes, const ReadOptions&) {
    LineScanner lines(bytes);
    Line line;
    const std::optional<double> announced = read_header(lines, line);
    const auto names = split(keyed(line.text).value, ',');
    if (names.size() < 5 || names.size() - 4 > kChannelsMax)
        fail_at(line, "VARS names " + std::to_string(names.size()) +
                          " columns; four angles and 1 to " + std::to_string(kChannelsMax) +
                          " values are read");
    Component part{"reflection front", {}, {}};
    for (std::size_t c = 4; c < names.size(); ++c)
        part.cloud.channels.push_back(channel_name(names[c]));
    const Rows rows = read_rows(lines, names.size());
    const std::size_t count = rows.numbers.size() / rows.width;
    const std::string counts =
        std::to_string(count) + " rows, NUM_POINTS announces " + in_words(announced.value_or(0));
    if (announced && static_cast<double>(count) < *announced)
        throw Error("malformed_measurement", "line " + std::to_string(lines.line_number()) +
                                                 ": the file ends after " + counts);
    Reading reading;
    Understood& account = reading.understood;
    if (announced && static_cast<double>(count) > *announced) account.warn(counts);
    if (!announced) warn_of_cut(rows.order, account);
    warn_of_open_end(lines, account);
    // The standard says radians; angles beyond a turn of radians can only be degrees.
    const bool radians = rows.angle_max <= 2 * std::numbers::pi + 1e-6;
    account.found("units", radians ? "radians" : "degrees",
                  "the largest angle is " + in_words(rows.angle_max));
    if (!radians) account.warn("the standard asks for radians");
    const double unit = radians ? 1 / kDegree : 1;
    std::size_t negative = 0;
    for (std::size_t n = 0; n + rows.width <= rows.numbers.size(); n += rows.width) {
        const double* row = rows.numbers.data() + n;
        for (std::size_t c = 4; c < rows.width; ++c) negative += row[c] < 0;
        add_point(part.cloud, {unit * row[0], unit * row[1], unit * row[2], unit * row[3]}, row + 4,
                  row[0] < 0 || row[2] < 0 ? PointState::kRejected : PointState::kMeasured);
    }
    account.found("convention", "f", "the standard stores a BSDF in 1/sr");
    account.found("angles", "absolute", "the standard's first four columns");
    account.found("azimuth", "from the sample's x axis, the mirror direction opposite to the light",
                  "the standard's definition");
    if (negative > 0)
        account.found("negative values", std::to_string(negative), "kept as measured");
    if (mirror_half(part.cloud))
        account.found("symmetry", "half mirrored",
                      "all points lie on one side of the plane of incidence");
    reading.components.push_back(std::move(part));
    return reading;
}

}  // namespace kiln::measured
