// SPDX-License-Identifier: Apache-2.0
// LightTools BSDF text, which MiniDiff exports: absolute angles, blocks in any order.
#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "server/base/error.h"
#include "server/measured/bounds.h"
#include "server/measured/mirror_azimuth.h"
#include "server/measured/readers.h"
#include "server/measured/text_scan.h"

namespace kiln::measured {
namespace {

/// The goniometer of this name measures to 75 degrees and writes a grid to 90.
constexpr double kMiniDiffReach = 75;
/// Noise below zero; what is lower was no measurement.
constexpr double kNoiseMin = -1;
/// Azimuth of the light in isotropic files of this format.
constexpr double kLightAzimuth = 90;

struct Header {
    std::string title, all_text;
    bool plane_symmetrical = false;
    std::vector<double> azimuth, radial;
    std::size_t azimuth_line = 0;
};

struct Block {
    double aoi = 0, poi = 0;
    bool back = false, transmission = false;
    std::string channel;
    double wavelength = 0;      ///< nm, or the rank of a tristimulus value
    std::vector<float> values;  ///< [azimuth][radial]
    std::size_t line = 0;
};

Header read_header(LineScanner& lines) {
    Header header;
    Line line;
    while (lines.next_with_comments(line)) {
        if (header.all_text.size() < 4096) header.all_text += lower_case(line.text.substr(0, 200));
        if (line.text.front() == '#') continue;
        const auto [key, value] = keyed(line.text);
        if (same_word(key, "DataBegin")) {
            if (header.azimuth.empty() || header.radial.empty())
                fail_at(line, "DataBegin before ScatterAzimuth and ScatterRadial");
            return header;
        }
        if (same_word(key, "Model"))
            header.title = plain_text(trimmed(value.substr(value.find(':') + 1)));
        if (same_word(key, "Symmetry"))
            header.plane_symmetrical = same_word(value, "PlaneSymmetrical");
        const bool azimuth = same_word(key, "ScatterAzimuth");
        if (azimuth || same_word(key, "ScatterRadial")) {
            auto& list = azimuth ? header.azimuth : header.radial;
            list = read_list(lines, line, key, parse_number(value).value_or(0), kAxisAnglesMax);
            for (const double v : list)
                if (v < (azimuth ? -360.0 : 0.0) || v > (azimuth ? 360.0 : 90.0))
                    fail_at(line, "an angle of " + in_words(v) + " in " + plain_text(key));
        }
    }
    throw Error("malformed_measurement",
                "line " + std::to_string(lines.line_number()) + ": the file ends before DataBegin");
}

/// What comes after a block.
enum class After { kBlock, kDataEnd, kNothing };

/// The keys of a block until the first row of numbers, which stays unread.
bool read_block_keys(LineScanner& lines, Block& block, After& after) {
    Line line;
    bool any = false;
    while (lines.next(line)) {
        const auto [key, value] = keyed(line.text);
        const auto number = [&, key = key, value = value] {  // Clang captures no binding
            const auto parsed = parse_number(value);
            if (!parsed) fail_at(line, plain_text(key) + " without a number");
            return *parsed;
        };
        if (same_word(key, "AOI")) {
            block.aoi = number();
            block.line = line.number;
            if (block.aoi < 0 || block.aoi > 180) fail_at(line, "AOI outside 0 to 180");
        } else if (same_word(key, "POI")) {
            block.poi = number();
            if (std::abs(block.poi) > 360) fail_at(line, "POI beyond a turn");
        } else if (same_word(key, "Side")) {
            block.back = same_word(value, "Back");
        } else if (same_word(key, "Wavelength")) {
            block.wavelength = number();
            block.channel = in_words(block.wavelength) + "nm";
        } else if (same_word(key, "TristimulusValue")) {
            const std::size_t rank =
                std::string_view("XYZ").find(value.empty() ? '?' : value.back());
            if (rank == std::string_view::npos) fail_at(line, "a tristimulus value beside X, Y, Z");
            block.channel = std::string(1, "XYZ"[rank]);
            block.wavelength = -static_cast<double>(rank);
        } else if (same_word(key, "ScatterType")) {
            block.transmission = same_word(value, "BTDF");
        } else if (same_word(key, "TIS")) {
            number();
        } else if (same_word(key, "DataEnd")) {
            after = After::kDataEnd;
            return any;
        } else if (parse_number(key)) {
            lines.put_back();
            return true;
        } else {
            fail_at(line, "\"" + plain_text(key) + "\" is no key of a block");
        }
        any = true;
    }
    after = After::kNothing;
    return any;
}

std::vector<Block> read_blocks(LineScanner& lines, const Header& header, Understood& account) {
    std::vector<Block> blocks;
    std::vector<double> row;
    std::size_t total = 0;
    After after = After::kBlock;
    while (after == After::kBlock) {
        Block block;
        if (!blocks.empty()) {  // what a block does not say stays as it was
            block = blocks.back();
            block.values.clear();
        }
        const bool any = read_block_keys(lines, block, after);
        if (after != After::kBlock && !any) break;
        if (blocks.size() >= kBlocksMax)
            throw Error("malformed_measurement",
                        "more than " + std::to_string(kBlocksMax) + " blocks");
        total += header.azimuth.size() * header.radial.size();
        if (total > kValuesMax)
            throw Error("measurement_too_large",
                        "the blocks hold more than " + std::to_string(kValuesMax) + " values");
        for (std::size_t a = 0; a < header.azimuth.size(); ++a) {
            const Line line = lines.expect("a row of values");
            parse_numbers(line, row);
            if (row.size() != header.radial.size())
                fail_at(line, std::to_string(row.size()) + " values, ScatterRadial announces " +
                                  std::to_string(header.radial.size()));
            for (const double v : row) block.values.push_back(static_cast<float>(v));
        }
        if (block.channel.empty()) block.channel = "value";
        blocks.push_back(std::move(block));
    }
    if (after == After::kNothing)
        account.warn("no line DataEnd: the file may have been cut off after a block");
    return blocks;
}

std::string component_name(const Block& block) {
    return std::string(block.transmission ? "transmission " : "reflection ") +
           (block.back || block.aoi > 90 ? "back" : "front");
}

/// The channels in the order of falling wavelength (red first), or X, Y, Z.
std::vector<std::string> channel_order(const std::vector<const Block*>& blocks) {
    std::map<double, std::string, std::greater<>> by_wavelength;
    for (const Block* block : blocks) by_wavelength[block->wavelength] = block->channel;
    std::vector<std::string> names;
    for (const auto& [wavelength, name] : by_wavelength) names.push_back(name);
    return names;
}

struct Counts {
    std::size_t negative = 0, rejected = 0, beyond = 0, all = 0;
};

void fill_incidence(Cloud& cloud, const Header& header, const std::vector<const Block*>& channels,
                    double theta_max, Counts& counts) {
    std::vector<double> values(channels.size());
    const Block& first = *channels.front();
    const double theta_i = first.aoi > 90 ? 180 - first.aoi : first.aoi;
    std::size_t n = 0;
    for (const double azimuth : header.azimuth)
        for (const double radial : header.radial) {
            bool rejected = false;
            for (std::size_t c = 0; c < channels.size(); ++c) {
                values[c] = channels[c]->values[n];
                counts.negative += values[c] < 0;
                rejected = rejected || values[c] < kNoiseMin;
            }
            ++n;
            const bool beyond = radial > theta_max + 1e-6;
            ++counts.all;
            counts.beyond += beyond;
            counts.rejected += rejected && !beyond;
            add_point(cloud, {theta_i, first.poi, radial, azimuth}, values.data(),
                      beyond     ? PointState::kNotMeasured
                      : rejected ? PointState::kRejected
                                 : PointState::kMeasured);
        }
}

/// All blocks of one side and kind of scattering.
Component make_component(const Header& header, const std::vector<const Block*>& blocks,
                         double theta_max, Counts& counts) {
    Component part;
    part.name = component_name(*blocks.front());
    part.cloud.channels = channel_order(blocks);
    std::map<std::pair<double, double>, std::map<std::string, const Block*>> incidences;
    for (const Block* block : blocks) {
        const Block*& place = incidences[{block->aoi, block->poi}][block->channel];
        if (place)
            throw Error("malformed_measurement", "line " + std::to_string(block->line) +
                                                     ": the same block as at line " +
                                                     std::to_string(place->line));
        place = block;
    }
    for (const auto& [incidence, by_channel] : incidences) {
        std::vector<const Block*> channels;
        for (const std::string& name : part.cloud.channels) {
            const auto found = by_channel.find(name);
            if (found == by_channel.end())
                throw Error("malformed_measurement",
                            "line " + std::to_string(by_channel.begin()->second->line) +
                                ": the incidence of " + in_words(incidence.first) +
                                " degrees lacks the channel " + name);
            channels.push_back(found->second);
        }
        fill_incidence(part.cloud, header, channels, theta_max, counts);
    }
    return part;
}

void explain(Understood& account, const Header& header, const Counts& counts, double theta_max) {
    account.title = header.title;
    account.found("convention", "f", "the format stores a BSDF in 1/sr");
    account.found("units", "degrees, 1/sr", "the format's definition");
    account.found("angles", "absolute", "no line AngleOfIncidence before DataBegin");
    if (counts.beyond > 0)
        account.found("mask", "beyond " + in_words(theta_max) + " degrees",
                      std::to_string(counts.beyond) + " points that the instrument cannot reach");
    if (counts.negative > 0)
        account.found("negative values", std::to_string(counts.negative),
                      "noise around zero; kept, so that averages stay unbiased");
    if (counts.rejected > 0)
        account.warn(std::to_string(counts.rejected) + " values below -1 are no noise; dropped");
    account.leave_out("the TIS lines", "albedos are integrated from the values");
}

}  // namespace

bool is_lighttools(std::string_view bytes) {
    return line_starts(bytes, "ScatterAzimuth", "DataBegin") &&
           line_starts(bytes, "ScatterRadial", "DataBegin") && line_starts(bytes, "DataBegin") &&
           !line_starts(bytes, "AngleOfIncidence", "DataBegin");
}

Reading read_lighttools(std::string_view bytes, const ReadOptions& options) {
    LineScanner lines(bytes);
    const Header header = read_header(lines);
    Reading reading;
    const std::vector<Block> blocks = read_blocks(lines, header, reading.understood);
    const bool minidiff = header.all_text.find("minidiff") != std::string::npos;
    const double theta_max = options.theta_out_max_deg.value_or(minidiff ? kMiniDiffReach : 90.0);
    std::map<std::tuple<bool, bool>, std::vector<const Block*>> groups;
    for (const Block& block : blocks)
        groups[{block.transmission, block.back || block.aoi > 90}].push_back(&block);
    Counts counts;
    for (const auto& [key, group] : groups) {
        reading.components.push_back(make_component(header, group, theta_max, counts));
        Component& part = reading.components.back();
        if (header.plane_symmetrical && mirror_half(part.cloud))
            reading.understood.found("symmetry", "half mirrored", "the line Symmetry");
        if (part.name.starts_with("reflection"))
            settle_light_azimuth(part.cloud, kLightAzimuth, options, reading.understood);
    }
    explain(reading.understood, header, counts, theta_max);
    if (!blocks.empty() && blocks.front().wavelength > 0 &&
        reading.components[0].cloud.channels.size() == 3)
        reading.understood.warn(
            "three wavelengths of lamps are no primaries of a colour space; "
            "they are taken as red, green and blue as they are");
    return reading;
}

}  // namespace kiln::measured
