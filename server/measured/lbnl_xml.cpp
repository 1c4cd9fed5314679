// SPDX-License-Identifier: Apache-2.0
// LBNL WINDOW 6/7 BSDF XML with a Klems basis: matrices over patches of incidence and exitance.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <pugixml.hpp>

#include "server/base/error.h"
#include "server/measured/angles.h"
#include "server/measured/bounds.h"
#include "server/measured/readers.h"
#include "server/measured/text_scan.h"

namespace kiln::measured {
namespace {

struct Patch {
    double theta = 0, phi = 0;  ///< degrees
    double solid = 0;           ///< projected, sr
};

[[noreturn]] void fail_in(const pugi::xml_node& node, const std::string& what) {
    throw Error("malformed_measurement",
                "byte " + std::to_string(node.offset_debug()) + ": " + what);
}

double number_in(const pugi::xml_node& parent, const char* name) {
    const pugi::xml_node node = parent.child(name);
    const auto value = parse_number(trimmed(node.text().get()));
    if (!value) fail_in(parent, std::string(name) + " is missing or no number");
    return *value;
}

std::vector<Patch> read_basis(const pugi::xml_node& definition) {
    const pugi::xml_node basis = definition.child("AngleBasis");
    std::vector<Patch> patches;
    for (const pugi::xml_node block : basis.children("AngleBasisBlock")) {
        const double theta = number_in(block, "Theta"), phis = number_in(block, "nPhis");
        const pugi::xml_node bounds = block.child("ThetaBounds");
        const double low = number_in(bounds, "LowerTheta"), high = number_in(bounds, "UpperTheta");
        if (!(theta >= low && theta <= high && low >= 0 && high <= 90 && low < high))
            fail_in(block, "angles that do not rise within 0 to 90 degrees");
        if (!(phis >= 1 && phis <= 720) || phis != std::floor(phis))
            fail_in(block, "nPhis is no count from 1 to 720");
        const double sine_low = std::sin(low * kDegree), sine_high = std::sin(high * kDegree);
        const double solid =
            std::numbers::pi * (sine_high * sine_high - sine_low * sine_low) / phis;
        for (int k = 0; k < static_cast<int>(phis); ++k)
            patches.push_back({theta, 360.0 * k / phis, solid});
        if (patches.size() > kPatchesMax) fail_in(block, "too many patches");
    }
    if (patches.empty()) fail_in(definition, "an AngleBasis with AngleBasisBlocks was expected");
    return patches;
}

std::vector<float> read_matrix(const pugi::xml_node& node, std::size_t patches) {
    std::string_view rest = node.text().get();
    std::vector<float> matrix;
    matrix.reserve(patches * patches);
    constexpr std::string_view kSeparators = " \t\r\n,;";
    while (true) {
        const std::size_t start = rest.find_first_not_of(kSeparators);
        if (start == rest.npos) break;
        rest.remove_prefix(start);
        const std::size_t length = std::min(rest.find_first_of(kSeparators), rest.size());
        const auto value = parse_number(rest.substr(0, length));
        if (!value)
            fail_in(node, "number " + std::to_string(matrix.size() + 1) + " of the matrix, \"" +
                              plain_text(rest.substr(0, std::min<std::size_t>(length, 40))) +
                              "\", is no finite number");
        if (matrix.size() == patches * patches)
            fail_in(node, "more than " + std::to_string(patches * patches) + " numbers");
        matrix.push_back(static_cast<float>(*value));
        rest.remove_prefix(length);
    }
    if (matrix.size() != patches * patches)
        fail_in(node, std::to_string(matrix.size()) + " numbers, " +
                          std::to_string(patches * patches) + " were expected");
    return matrix;
}

/// Whether equal patch numbers are mirror directions: brighter there than at the opposite patch,
/// summed over the patches between 35 and 75 degrees.
bool diagonal_is_mirror(const std::vector<Patch>& patches, const std::vector<float>& matrix) {
    double same = 0, opposite = 0;
    const std::size_t count = patches.size();
    for (std::size_t j = 0; j < count; ++j) {
        if (patches[j].theta < 35 || patches[j].theta > 75) continue;
        for (std::size_t i = 0; i < count; ++i) {
            if (patches[i].theta != patches[j].theta) continue;
            const double turn = wrapped_degrees(patches[i].phi - patches[j].phi);
            if (turn < 1e-9) same += matrix[i * count + j];
            if (std::abs(turn - 180) < 1e-9) opposite += matrix[i * count + j];
        }
    }
    return same >= opposite;
}

std::string component_name(const pugi::xml_node& data, std::string_view direction_text) {
    const std::string spectrum = plain_text(trimmed(data.child("Wavelength").text().get()));
    return lower_case(direction_text) + ", " + lower_case(spectrum.substr(0, 32));
}

struct Layout {
    std::vector<Patch> patches;
    bool columns = true;  ///< a column of the matrix is an incidence
};

Component make_component(const pugi::xml_node& data, const pugi::xml_node& block,
                         const Layout& layout, Understood& account) {
    const std::string towards =
        plain_text(trimmed(block.child("WavelengthDataDirection").text().get())).substr(0, 40);
    Component part{component_name(data, towards), {}, {}};
    part.cloud.channels = {"value"};
    const std::size_t count = layout.patches.size();
    std::vector<float> matrix = read_matrix(block.child("ScatteringData"), count);
    if (!layout.columns)
        for (std::size_t i = 0; i < count; ++i)
            for (std::size_t j = 0; j < i; ++j)
                std::swap(matrix[i * count + j], matrix[j * count + i]);
    const bool mirror = diagonal_is_mirror(layout.patches, matrix);
    account.found(
        "azimuth",
        part.name + ": equal patches are " + (mirror ? "mirror directions" : "one direction"),
        "where the matrix is brighter between 35 and 75 degrees");
    for (std::size_t j = 0; j < count; ++j)
        for (std::size_t i = 0; i < count; ++i) {
            const Patch &in = layout.patches[j], &out = layout.patches[i];
            const double value = matrix[i * count + j];
            add_point(part.cloud, {in.theta, in.phi, out.theta, out.phi + (mirror ? 180 : 0)},
                      &value);
            part.cloud.patch.push_back(static_cast<float>(out.solid));
        }
    return part;
}

}  // namespace

bool is_lbnl_xml(std::string_view bytes) {
    return bytes.substr(0, 4096).find("<WindowElement") != std::string_view::npos;
}

Reading read_lbnl_xml(std::string_view bytes, const ReadOptions&) {
    const auto tags = static_cast<std::size_t>(std::count(bytes.begin(), bytes.end(), '<'));
    if (bytes.size() > kDocumentBytesMax || tags > kXmlTagsMax)
        throw Error("measurement_too_large", "an XML file of " + std::to_string(bytes.size()) +
                                                 " bytes and " + std::to_string(tags) + " tags; " +
                                                 std::to_string(kDocumentBytesMax) + " and " +
                                                 std::to_string(kXmlTagsMax) + " are read");
    pugi::xml_document document;
    // No entities are expanded beyond the five of XML: the parser knows no document types.
    const pugi::xml_parse_result parsed =
        document.load_buffer(bytes.data(), bytes.size(), pugi::parse_minimal | pugi::parse_escapes);
    if (!parsed)
        throw Error("malformed_measurement",
                    "byte " + std::to_string(parsed.offset) + ": " + parsed.description());
    const pugi::xml_node layer = document.child("WindowElement").child("Optical").child("Layer");
    const pugi::xml_node definition = layer.child("DataDefinition");
    const std::string structure(trimmed(definition.child("IncidentDataStructure").text().get()));
    if (!same_word(structure, "Columns") && !same_word(structure, "Rows"))
        fail_in(definition, "IncidentDataStructure is \"" + plain_text(structure) +
                                "\"; Columns and Rows are read");
    const Layout layout{read_basis(definition), same_word(structure, "Columns")};
    Reading reading;
    Understood& account = reading.understood;
    account.title = plain_text(trimmed(layer.child("Material").child("Name").text().get()));
    account.found("convention", "f",
                  "the format stores a BSDF in 1/sr, also where "
                  "ScatteringDataType says BTDF of a reflection");
    account.found("units", "degrees, 1/sr", "the format's definition");
    account.found("angles", std::to_string(layout.patches.size()) + " patches, constant in each",
                  "the AngleBasis");
    for (const pugi::xml_node data : layer.children("WavelengthData"))
        for (const pugi::xml_node block : data.children("WavelengthDataBlock")) {
            if (reading.components.size() >= kComponentsMax) fail_in(block, "too many blocks");
            reading.components.push_back(make_component(data, block, layout, account));
        }
    // Tables are made of what a viewer in front of the layer sees.
    std::stable_partition(
        reading.components.begin(), reading.components.end(),
        [](const Component& part) { return part.name.starts_with("reflection front, visible"); });
    return reading;
}

}  // namespace kiln::measured
