// SPDX-License-Identifier: Apache-2.0
// FRED tabulated scatter: sections of points in absolute angles, each under a mirror direction.
#include <algorithm>
#include <cmath>

#include "server/base/error.h"
#include "server/measured/angles.h"
#include "server/measured/readers.h"
#include "server/measured/scan_order.h"
#include "server/measured/text_scan.h"

namespace kiln::measured {
namespace {

struct Format {
    bool sines = false, logarithms = false;
    double scale = 1;
};

Format read_format(const Line& line) {
    Format format;
    if (!same_word(keyed(line.text).key, "format")) fail_at(line, "a line \"format ...\" expected");
    std::string text(keyed(line.text).value);
    std::replace(text.begin(), text.end(), '\t', ' ');
    for (const std::string_view entry : split(text, ' ')) {
        const std::size_t equals = entry.find('=');
        if (equals == entry.npos) continue;
        const std::string_view key = entry.substr(0, equals), value = entry.substr(equals + 1);
        const auto one_of = [&](std::string_view first, std::string_view second) {
            if (!same_word(value, first) && !same_word(value, second))
                fail_at(line, plain_text(key) + " is \"" + plain_text(value) + "\", " +
                                  std::string(first) + " and " + std::string(second) +
                                  " are possible");
            return same_word(value, second);
        };
        if (same_word(key, "angles")) format.sines = one_of("deg", "sin");
        if (same_word(key, "bsdf")) format.logarithms = one_of("value", "log");
        if (same_word(key, "scale")) {
            const auto scale = parse_number(value);
            if (!scale || !(*scale > 0)) fail_at(line, "scale is no positive number");
            format.scale = *scale;
        }
    }
    return format;
}

/// Theta and phi in degrees of a pair as the file writes it; a negative theta is the other side.
struct Polar {
    double theta = 0, phi = 0;
};
Polar polar(const Line& line, const Format& format, double first, double second) {
    if (!format.sines) {
        if (std::abs(first) > 180 || std::abs(second) > 720)
            fail_at(line, "an angle beyond a turn");
        return first < 0 ? Polar{-first, second + 180} : Polar{first, second};
    }
    // alpha = sin phi sin theta, beta = cos phi sin theta.
    const double sine = std::hypot(first, second);
    if (sine > 1 + 1e-6) fail_at(line, "sines whose squares sum to more than 1");
    return {std::asin(std::min(1.0, sine)) / kDegree, phi_of({second, first, 0})};
}

}  // namespace

bool is_fred(std::string_view bytes) {
    LineScanner lines(bytes.substr(0, 4096));
    try {
        Line line;
        return lines.next(line) && same_word(keyed(line.text).key, "type") &&
               same_word(keyed(line.text).value, "bsdf_data");
    } catch (const Error&) {
        return false;
    }
}

Reading read_fred(std::string_view bytes, const ReadOptions&) {
    LineScanner lines(bytes);
    lines.expect("type bsdf_data");
    const Format format = read_format(lines.expect("a line format"));
    Component front{"reflection front", {}, {}}, through{"transmission front", {}, {}};
    front.cloud.channels = through.cloud.channels = {"value"};
    std::vector<double> row;
    Polar mirror;
    ScanOrder order(format.sines ? std::array<std::string_view, 2>{"alpha", "beta"}
                                 : std::array<std::string_view, 2>{"theta", "phi"});
    std::size_t sections = 0;
    Line line;
    while (lines.next(line)) {
        parse_numbers(line, row);
        if (row.size() == 2) {
            mirror = polar(line, format, row[0], row[1]);
            if (mirror.theta > 90) fail_at(line, "a mirror direction below the horizon");
            ++sections;
            order.start_section();
            continue;
        }
        if (row.size() != 3 || sections == 0)
            fail_at(line, std::to_string(row.size()) +
                              " numbers; a section starts with two, a point has three");
        const Polar out = polar(line, format, row[0], row[1]);
        const double value = format.scale * (format.logarithms ? std::pow(10.0, row[2]) : row[2]);
        if (!std::isfinite(value)) fail_at(line, "a value beyond any double");
        order.add(row[0], row[1]);
        const bool behind = out.theta > 90;
        const double theta_o = behind ? 180 - out.theta : out.theta;
        add_point((behind ? through : front).cloud,
                  {mirror.theta, mirror.phi + 180, theta_o, out.phi}, &value);
    }
    if (sections > 0 && order.section_is_empty())
        fail_at(line, "the file ends after the two numbers that start a section");
    if (const std::string proof = order.look().proof; !proof.empty())
        fail_at(line, "the file was cut off: " + proof);
    Reading reading;
    Understood& account = reading.understood;
    warn_of_cut(order, account);
    warn_of_open_end(lines, account);
    account.found("convention", "f", "the format stores a BSDF in 1/sr");
    account.found("units", format.sines ? "sines" : "degrees", "the line format");
    if (format.scale != 1 || format.logarithms)
        account.found("scale",
                      in_words(format.scale) + (format.logarithms ? ", of powers of 10" : ""),
                      "the line format");
    account.found("incidences", std::to_string(sections), "rows of two numbers");
    account.found("azimuth", "absolute, the mirror direction as each section gives it",
                  "rows of two numbers");
    for (Component* part : {&front, &through}) {
        if (part->cloud.size() == 0) continue;
        if (mirror_half(part->cloud))
            account.found("symmetry", "half mirrored",
                          "all azimuths lie on one side of the plane of incidence");
        reading.components.push_back(std::move(*part));
    }
    if (sections == 1) account.warn("a single incidence: everything at other ones is a guess");
    return reading;
}

}  // namespace kiln::measured
