// SPDX-License-Identifier: Apache-2.0
// Columns under a line of names: four angles and values, separated by commas, semicolons or tabs.
#include <algorithm>
#include <array>
#include <numbers>
#include <optional>

#include "server/base/error.h"
#include "server/measured/angles.h"
#include "server/measured/bounds.h"
#include "server/measured/readers.h"
#include "server/measured/scan_order.h"
#include "server/measured/text_scan.h"

namespace kiln::measured {
namespace {

constexpr std::size_t kNone = static_cast<std::size_t>(-1);

/// The angles by the names that instruments give them.
constexpr std::array<std::array<std::string_view, 5>, 4> kAngleNames = {{
    {"theta_in", "theta_i", "thetai", "src_z", "aoi"},
    {"phi_in", "phi_i", "phii", "src_a", "poi"},
    {"theta_out", "theta_o", "theta_r", "theta_s", "view_z"},
    {"phi_out", "phi_o", "phi_r", "phi_s", "view_a"},
}};

struct Head {
    std::array<std::size_t, 4> angle{kNone, kNone, kNone, kNone};
    std::vector<std::size_t> value;
    std::vector<std::string> channels;
    std::size_t columns = 0;
    bool radians = false, unit_named = false, factor = false;
    char separator = ',';
    std::string title, factor_evidence;
};

char separator_of(std::string_view text) {
    for (const char c : {'\t', ';', ','})
        if (text.find(c) != text.npos) return c;
    return ' ';
}

/// A name without its unit: "theta_in [deg]", "theta_in(rad)" and "theta_in_deg" are theta_in.
std::string bare_name(std::string_view field, Head& head) {
    std::string name = lower_case(field);
    for (const auto& [unit, radians] : {std::pair{"rad", true}, std::pair{"deg", false}}) {
        const std::size_t at = name.find(unit);
        if (at == std::string::npos || at == 0) continue;
        head.radians = head.radians || radians;
        head.unit_named = true;
        name.resize(at);
    }
    while (!name.empty() && std::string_view(" _[(").find(name.back()) != std::string_view::npos)
        name.pop_back();
    return name;
}

/// The line of names, or nothing where the four angles are not all there.
std::optional<Head> parse_head(std::string_view text) {
    Head head;
    head.separator = separator_of(text);
    const auto fields = split(text.starts_with('#') ? text.substr(1) : text, head.separator);
    if (fields.size() < 5 || fields.size() > kChannelsMax + 4) return std::nullopt;
    head.columns = fields.size();
    for (std::size_t column = 0; column < fields.size(); ++column) {
        const std::string name = bare_name(fields[column], head);
        bool angle = false;
        for (std::size_t a = 0; a < kAngleNames.size(); ++a)
            if (std::find(kAngleNames[a].begin(), kAngleNames[a].end(), name) !=
                kAngleNames[a].end()) {
                if (head.angle[a] != kNone) return std::nullopt;
                head.angle[a] = column;
                angle = true;
            }
        if (angle) continue;
        head.value.push_back(column);
        std::string channel = plain_text(fields[column]).substr(0, 32);
        if (name == "r" || name == "g" || name == "b") channel = static_cast<char>(name[0] - 32);
        if (name == "brdf" || name == "f") channel = "value";
        if (name == "brf") head.factor_evidence = "a column of the name BRF";
        head.channels.push_back(channel);
    }
    const bool whole = std::find(head.angle.begin(), head.angle.end(), kNone) == head.angle.end();
    if (!whole || head.value.empty()) return std::nullopt;
    head.factor = !head.factor_evidence.empty();
    return head;
}

/// Whether a line of preface speaks of a reflectance factor.
bool speaks_of_factor(std::string_view text) {
    const std::string lower = lower_case(text.substr(0, 400));
    return lower.starts_with("brf ") || lower == "brf" ||
           lower.find("reflectance factor") != lower.npos;
}

std::optional<Head> find_head(LineScanner& lines) {
    Line line;
    std::string title, evidence;
    for (std::size_t n = 0; n < kPrefaceLinesMax && lines.next_with_comments(line); ++n) {
        if (auto head = parse_head(line.text)) {
            head->title = title;
            if (!evidence.empty()) {
                head->factor = true;
                head->factor_evidence = evidence;
            }
            return head;
        }
        if (speaks_of_factor(line.text))
            evidence = "line " + std::to_string(line.number) + " says \"" +
                       plain_text(line.text.substr(0, 60)) + "\"";
        else if (title.empty() && line.text.front() != '#')
            title = plain_text(line.text);
    }
    return std::nullopt;
}

/// One row after the other into the cloud; the largest theta is kept for the unit's check.
double read_rows(LineScanner& lines, const Head& head, Component& part, ScanOrder& order) {
    const double unit = head.radians ? 1 / kDegree : 1;
    const double scale = head.factor ? 1 / std::numbers::pi : 1;
    std::vector<double> row, values(head.value.size());
    double theta_max = 0;
    std::array<double, 2> light{};
    Line line;
    while (lines.next(line)) {
        parse_numbers(line, row);
        if (row.size() != head.columns)
            fail_at(line, std::to_string(row.size()) + " numbers under " +
                              std::to_string(head.columns) + " names");
        std::array<double, 4> angle{};
        for (std::size_t a = 0; a < 4; ++a) {
            angle[a] = row[head.angle[a]] * unit;
            if (!(std::abs(angle[a]) <= 720)) fail_at(line, "an angle beyond two turns");
        }
        if (part.cloud.size() == 0 || light != std::array{angle[0], angle[1]})
            order.start_section();
        light = {angle[0], angle[1]};
        order.add(angle[2], angle[3]);
        for (std::size_t a = 0; a < 4; a += 2) {
            theta_max = std::max(theta_max, angle[a]);
            if (angle[a] < 0) {  // the other side of the normal
                angle[a] = -angle[a];
                angle[a + 1] += 180;
            }
        }
        for (std::size_t c = 0; c < values.size(); ++c) values[c] = row[head.value[c]] * scale;
        add_point(part.cloud, {angle[0], angle[1], angle[2], angle[3]}, values.data());
    }
    return theta_max;
}

}  // namespace

bool is_csv(std::string_view bytes) {
    try {
        LineScanner lines(bytes.substr(0, std::size_t{64} << 10));
        return find_head(lines).has_value();
    } catch (const Error&) {
        return false;
    }
}

Reading read_csv(std::string_view bytes, const ReadOptions&) {
    LineScanner lines(bytes);
    const std::optional<Head> head = find_head(lines);
    if (!head) throw Error("malformed_measurement", "line 1: no line names the four angles");
    Component part{"reflection front", {}, {}};
    part.cloud.channels = head->channels;
    ScanOrder order({"theta_out", "phi_out"});
    const double theta_max = read_rows(lines, *head, part, order);
    Reading reading;
    Understood& account = reading.understood;
    warn_of_cut(order, account);
    warn_of_open_end(lines, account);
    account.title = head->title;
    account.found("convention", head->factor ? "reflectance factor, divided by pi" : "f",
                  head->factor ? head->factor_evidence : "no line speaks of a reflectance factor");
    account.found("units", head->radians ? "radians" : "degrees",
                  head->unit_named ? "the names of the columns" : "the usual unit of this format");
    account.found("azimuth", "from the sample's x axis, the mirror direction opposite to the light",
                  "this format's definition");
    if (!head->unit_named && theta_max > 0 && theta_max <= std::numbers::pi / 2 + 1e-6)
        account.warn("no theta exceeds " + in_words(theta_max) +
                     " degrees: are these radians? Name the unit, as in theta_in_rad");
    if (mirror_half(part.cloud))
        account.found("symmetry", "half mirrored",
                      "all points lie on one side of the plane of incidence");
    reading.components.push_back(std::move(part));
    return reading;
}

}  // namespace kiln::measured
