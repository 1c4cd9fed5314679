// SPDX-License-Identifier: Apache-2.0
// BiRD universal BRDF JSON: parallel arrays, one reading an index.
#include <array>
#include <map>
#include <nlohmann/json.hpp>

#include "server/base/error.h"
#include "server/measured/angles.h"
#include "server/measured/bounds.h"
#include "server/measured/readers.h"
#include "server/measured/text_scan.h"
#include "server/spec/json_text.h"
#include "server/spec/spec.h"

namespace kiln::measured {
namespace {

using nlohmann::json;

[[noreturn]] void fail(const std::string& pointer, const std::string& what) {
    throw Error("malformed_measurement", pointer + ": " + what);
}

const json& member(const json& object, const char* name, const std::string& pointer) {
    if (!object.is_object() || !object.contains(name)) fail(pointer, "is missing");
    return object.at(name);
}

struct Column {
    std::vector<double> values;
    std::string unit;
};

Column read_column(const json& data, const char* name) {
    const std::string pointer = std::string("/data/") + name;
    const json& object = member(data, name, pointer);
    const json& values = member(object, "values", pointer + "/values");
    if (!values.is_array()) fail(pointer + "/values", "is no array");
    Column column;
    if (object.contains("unit") && object.at("unit").is_string())
        column.unit = object.at("unit").get<std::string>();
    for (std::size_t n = 0; n < values.size(); ++n) {
        if (!values[n].is_number()) fail(pointer + "/values/" + std::to_string(n), "is no number");
        column.values.push_back(values[n].get<double>());
    }
    return column;
}

/// In degrees.
std::vector<double> angles_of(const json& data, const char* name, std::size_t count) {
    const Column column = read_column(data, name);
    const std::string pointer = std::string("/data/") + name;
    if (column.values.size() != count)
        fail(pointer + "/values", "has " + std::to_string(column.values.size()) +
                                      " entries, BRDF has " + std::to_string(count));
    const bool degrees =
        column.unit == "\xc2\xb0" || same_word(column.unit, "deg") || column.unit.empty();
    if (!degrees && !same_word(column.unit, "rad"))
        fail(pointer + "/unit", "is \"" + plain_text(column.unit) + "\"; deg and rad are read");
    std::vector<double> angles;
    for (const double v : column.values) {
        angles.push_back(degrees ? v : v / kDegree);
        if (!(std::abs(angles.back()) <= 720)) fail(pointer, "holds an angle beyond two turns");
    }
    return angles;
}

std::vector<double> wavelengths_of(const json& data, std::size_t count) {
    if (!data.contains("wavelength_i")) return std::vector<double>(count, 0.0);
    Column column = read_column(data, "wavelength_i");
    if (column.values.size() != count)
        fail("/data/wavelength_i/values", "has another length than BRDF");
    const bool micro =
        column.unit == "\xce\xbcm" || column.unit == "\xc2\xb5m" || same_word(column.unit, "um");
    for (double& v : column.values) v *= micro ? 1000 : 1;
    return column.values;
}

/// Sum and number of the readings of one pair of directions in one channel.
struct Mean {
    double sum = 0;
    int count = 0;
};

void collect(Component& part, const std::array<std::vector<double>, 4>& angles,
             const std::vector<double>& wavelength, const std::vector<double>& values) {
    std::map<double, std::size_t> channel_of;
    for (const double w : wavelength) channel_of[w];
    if (channel_of.size() > kChannelsMax)
        fail("/data/wavelength_i", "has " + std::to_string(channel_of.size()) +
                                       " wavelengths, at most " + std::to_string(kChannelsMax));
    std::size_t next = 0;
    for (auto& [w, channel] : channel_of) {
        channel = next++;
        part.cloud.channels.push_back(w > 0 ? in_words(w) + "nm" : "value");
    }
    if (values.size() * channel_of.size() > kValuesMax)
        throw Error("measurement_too_large", "too many readings times wavelengths");
    std::map<std::array<double, 4>, std::vector<Mean>> places;
    for (std::size_t n = 0; n < values.size(); ++n) {
        auto& means = places[{angles[0][n], angles[1][n], angles[2][n], angles[3][n]}];
        means.resize(channel_of.size());
        Mean& mean = means[channel_of[wavelength[n]]];
        mean.sum += values[n];
        ++mean.count;
    }
    std::vector<double> row(channel_of.size());
    for (const auto& [at, means] : places) {
        bool whole = true;
        for (std::size_t c = 0; c < row.size(); ++c) {
            whole = whole && means[c].count > 0;
            row[c] = means[c].count > 0 ? means[c].sum / means[c].count : 0.0;
        }
        const bool possible = at[0] >= 0 && at[2] >= 0;
        add_point(part.cloud, {at[0], at[1], at[2], at[3]}, row.data(),
                  !possible ? PointState::kRejected
                  : whole   ? PointState::kMeasured
                            : PointState::kNotMeasured);
    }
}

}  // namespace

bool is_bird_json(std::string_view bytes) {
    if (bytes.size() > kFileBytesMax) return false;
    const std::size_t first = bytes.find_first_not_of(" \t\r\n");
    return first != bytes.npos && bytes[first] == '{' && bytes.find("\"theta_i\"") != bytes.npos &&
           bytes.find("\"BRDF\"") != bytes.npos;
}

Reading read_bird_json(std::string_view bytes, const ReadOptions&) {
    json document;
    try {
        document = parse_json(bytes, {static_cast<std::int64_t>(kDocumentBytesMax), 32});
    } catch (const Malformed& problem) {
        throw Error("malformed_measurement", problem.what());
    }
    const json& data = member(document, "data", "/data");
    const Column values = read_column(data, "BRDF");
    const std::size_t count = values.values.size();
    const std::array<std::vector<double>, 4> angles = {
        angles_of(data, "theta_i", count), angles_of(data, "phi_i", count),
        angles_of(data, "theta_r", count), angles_of(data, "phi_r", count)};
    const std::vector<double> wavelength = wavelengths_of(data, count);
    Reading reading;
    Understood& account = reading.understood;
    Component part{"reflection front", {}, {}};
    collect(part, angles, wavelength, values.values);
    if (const json::json_pointer name("/metadata/sample/name");
        document.contains(name) && document.at(name).is_string())
        account.title = plain_text(document.at(name).get<std::string>());
    account.found("convention", "f", "the unit of BRDF is \"" + plain_text(values.unit) + "\"");
    account.found("units", "degrees, 1/sr",
                  "the units of theta_i, \"" + plain_text(read_column(data, "theta_i").unit) +
                      "\", and of BRDF");
    account.found("azimuth", "from the sample's x axis, the mirror direction opposite to the light",
                  "the format's schema");
    account.found("angles", "absolute, directions away from the surface", "the format's schema");
    if (part.cloud.size() * part.cloud.channels.size() < count)
        account.found("polarisation", "averaged",
                      std::to_string(count) + " readings at " + std::to_string(part.cloud.size()) +
                          " pairs of directions and " + std::to_string(part.cloud.channels.size()) +
                          " wavelengths");
    if (data.contains("uBRDF"))
        account.leave_out("uBRDF", "uncertainties are not carried into tables");
    reading.components.push_back(std::move(part));
    return reading;
}

}  // namespace kiln::measured
