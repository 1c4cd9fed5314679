// SPDX-License-Identifier: Apache-2.0
// Zemax (Radiant) BSDF interchange text: angles about the mirror direction.
#include <cmath>

#include "server/base/error.h"
#include "server/measured/angles.h"
#include "server/measured/bounds.h"
#include "server/measured/readers.h"
#include "server/measured/text_scan.h"

namespace kiln::measured {
namespace {

struct Header {
    bool plane_symmetrical = false, xyz = false, transmission = false;
    std::vector<double> rotation, incidence, azimuth, radial;
    std::string title;
};

/// Values of one section, [rotation][incidence][azimuth][radial], and its TIS lines.
struct Section {
    std::string name;
    std::vector<float> values;
    std::vector<double> tis;
    bool open = false;  ///< its last line has no end
};

void check_range(const Line& line, std::string_view what, const std::vector<double>& list,
                 double low, double high) {
    for (const double v : list)
        if (v < low || v > high)
            fail_at(line, std::string(what) + " holds " + in_words(v) + ", " + in_words(low) +
                              " to " + in_words(high) + " are possible");
}

Header read_header(LineScanner& lines, Line& line) {
    Header header;
    while (lines.next(line)) {
        const auto [key, value] = keyed(line.text);
        // Named, for Clang captures no structured binding.
        const auto list = [&, key = key, value = value](std::vector<double>& into, double low,
                                                        double high) {
            into = read_list(lines, line, key, parse_number(value).value_or(0), kAxisAnglesMax);
            check_range(line, key, into, low, high);
        };
        if (same_word(key, "Symmetry")) {
            header.plane_symmetrical = same_word(value, "PlaneSymmetrical");
            if (!header.plane_symmetrical && !lower_case(value).starts_with("asymmetric"))
                fail_at(line, "the symmetry \"" + plain_text(value) +
                                  "\" is neither PlaneSymmetrical nor Asymmetrical");
        } else if (same_word(key, "SpectralContent")) {
            header.xyz = same_word(value, "XYZ");
        } else if (same_word(key, "ScatterType")) {
            header.transmission = same_word(value, "BTDF");
        } else if (same_word(key, "SampleRotation")) {
            list(header.rotation, -360, 360);
        } else if (same_word(key, "AngleOfIncidence")) {
            list(header.incidence, 0, 90);
        } else if (same_word(key, "ScatterAzimuth")) {
            list(header.azimuth, -360, 360);
        } else if (same_word(key, "ScatterRadial")) {
            list(header.radial, 0, 180);
        } else if (same_word(key, "Monochrome") || lower_case(key).starts_with("tristimulus")) {
            return header;
        } else if (same_word(key, "DataBegin")) {
            fail_at(line, "DataBegin before a line Monochrome or TristimulusX");
        }
    }
    throw Error("malformed_measurement",
                "line " + std::to_string(lines.line_number()) + ": the file ends in its header");
}

/// From DataBegin to the last block; `line` is the line that named the section.
Section read_section(LineScanner& lines, const Line& line, const Header& header) {
    Section section{std::string(plain_text(keyed(line.text).key)), {}, {}};
    Line row = lines.expect("DataBegin");
    if (!same_word(row.text, "DataBegin")) fail_at(row, "DataBegin was expected");
    std::vector<double> numbers;
    for (std::size_t r = 0; r < header.rotation.size(); ++r) {
        for (std::size_t i = 0; i < header.incidence.size(); ++i) {
            row = lines.expect("TIS");
            const auto [key, value] = keyed(row.text);
            const auto tis = parse_number(value);
            if (!same_word(key, "TIS") || !tis) fail_at(row, "TIS and a number were expected");
            section.tis.push_back(*tis);
            for (std::size_t a = 0; a < header.azimuth.size(); ++a) {
                row = lines.expect("a row of values");
                parse_numbers(row, numbers);
                if (numbers.size() != header.radial.size())
                    fail_at(row, std::to_string(numbers.size()) + " values, " +
                                     std::to_string(header.radial.size()) + " were announced");
                for (const double v : numbers) section.values.push_back(static_cast<float>(v));
                if (section.values.size() > kValuesMax) fail_at(row, "too many values");
            }
        }
    }
    section.open = !lines.line_has_end();
    if (lines.next(row) && !same_word(row.text, "DataEnd")) lines.put_back();
    return section;
}

struct Counts {
    std::size_t below = 0, empty = 0, all = 0;
};

Counts fill_cloud(Cloud& cloud, const Header& header, const std::vector<Section>& sections) {
    Counts counts;
    std::vector<double> values(sections.size());
    std::size_t n = 0;
    for (const double rotation : header.rotation)
        for (const double theta_i : header.incidence)
            for (const double azimuth : header.azimuth)
                for (const double radial : header.radial) {
                    bool zero = true;
                    for (std::size_t s = 0; s < sections.size(); ++s) {
                        values[s] = sections[s].values[n];
                        zero = zero && values[s] == 0;
                    }
                    ++n;
                    const Vec out = about_mirror(theta_i, rotation, radial, azimuth);
                    const double theta_o = theta_of(out);
                    ++counts.all;
                    const bool below = theta_o > 90.0 - 1e-6;
                    counts.below += below;
                    counts.empty += zero && !below;
                    add_point(cloud, {theta_i, rotation, theta_o, phi_of(out)}, values.data(),
                              below  ? PointState::kBelowHorizon
                              : zero ? PointState::kNotMeasured
                                     : PointState::kMeasured);
                }
    return counts;
}

void explain(Understood& account, const Header& header, const Counts& counts) {
    account.found("convention", "f", "the format stores a BSDF in 1/sr");
    account.found("units", "degrees, 1/sr", "the format's definition");
    account.found("angles", "about the mirror direction",
                  "the header lists SampleRotation and AngleOfIncidence");
    account.found("azimuth", "0 from the mirror direction towards the normal, counter-clockwise",
                  "the format's definition");
    account.found("symmetry", header.plane_symmetrical ? "plane of incidence" : "none",
                  "the line Symmetry");
    if (header.rotation.size() > 1)
        account.found("anisotropy", std::to_string(header.rotation.size()) + " sample rotations",
                      "the list SampleRotation, taken as azimuths of the light");
    const auto percent = [&](std::size_t part) {
        return in_words(100.0 * static_cast<double>(part) / static_cast<double>(counts.all)) +
               " % of the cells";
    };
    account.found("mask", percent(counts.below), "below the horizon, by geometry");
    account.found("mask", percent(counts.empty), "exactly zero above the horizon: not measured");
    account.leave_out("the TIS lines",
                      "they are no integral of f cos theta_o; albedos are "
                      "integrated from the values");
}

}  // namespace

bool is_zemax(std::string_view bytes) {
    return line_starts(bytes, "AngleOfIncidence", "DataBegin") &&
           line_starts(bytes, "SampleRotation", "DataBegin");
}

Reading read_zemax(std::string_view bytes, const ReadOptions&) {
    LineScanner lines(bytes);
    Line line;
    Reading reading;
    const Header header = read_header(lines, line);
    if (header.rotation.empty() || header.incidence.empty() || header.azimuth.empty() ||
        header.radial.empty())
        fail_at(line,
                "data before the lists SampleRotation, AngleOfIncidence, ScatterAzimuth and "
                "ScatterRadial");
    const double cells = static_cast<double>(header.rotation.size() * header.incidence.size()) *
                         static_cast<double>(header.azimuth.size() * header.radial.size());
    if (cells > static_cast<double>(kPointsMax))
        fail_at(line, "the lists make " + in_words(cells) + " cells, at most " +
                          std::to_string(kPointsMax) + " are read");
    std::vector<Section> sections;
    sections.push_back(read_section(lines, line, header));
    while (header.xyz && sections.size() < 3) {
        line = lines.expect("another tristimulus section");
        sections.push_back(read_section(lines, line, header));
    }
    if (sections.back().open) warn_of_open_end(lines, reading.understood);
    Component part;
    part.name = header.transmission ? "transmission front" : "reflection front";
    part.cloud.channels =
        header.xyz ? std::vector<std::string>{"X", "Y", "Z"} : std::vector<std::string>{"value"};
    const Counts counts = fill_cloud(part.cloud, header, sections);
    explain(reading.understood, header, counts);
    if (header.plane_symmetrical && mirror_half(part.cloud))
        reading.understood.found("symmetry", "half mirrored",
                                 "all azimuths lie on one side of the plane of incidence");
    reading.components.push_back(std::move(part));
    return reading;
}

}  // namespace kiln::measured
