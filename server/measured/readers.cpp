// SPDX-License-Identifier: Apache-2.0
#include "server/measured/readers.h"

#include <cmath>
#include <cstdio>

#include "server/base/error.h"
#include "server/measured/bounds.h"

namespace kiln::measured {

const std::vector<Reader>& readers() {
    static const std::vector<Reader> rows = {
        {"rgl", "RGL/EPFL tensor file, isotropic, rgb or spectra", is_rgl, read_rgl},
        {"merl", "MERL .binary, 90 x 90 x 180 or 360", is_merl, read_merl},
        {"lbnl_xml", "LBNL WINDOW XML", is_lbnl_xml, read_lbnl_xml},
        {"bird_json", "BiRD universal BRDF JSON", is_bird_json, read_bird_json},
        {"fred", "FRED tabulated scatter text", is_fred, read_fred},
        {"zemax", "Zemax/Radiant BSDF text", is_zemax, read_zemax},
        {"lighttools", "LightTools or MiniDiff BSDF text", is_lighttools, read_lighttools},
        {"astm", "ASTM E1392 text", is_astm, read_astm},
        {"csv", "columns theta_in, phi_in, theta_out, phi_out and values", is_csv, read_csv},
    };
    return rows;
}

namespace {

void check_component(const Component& part) {
    const Cloud& cloud = part.cloud;
    const std::size_t channels = cloud.channels.size();
    const std::string where = "the component \"" + part.name + "\" ";
    if (channels == 0 || channels > kChannelsMax)
        throw Error("malformed_measurement", where + "has " + std::to_string(channels) +
                                                 " channels, 1 to " + std::to_string(kChannelsMax) +
                                                 " are possible");
    bool any = false;
    for (std::size_t n = 0; n < cloud.size(); ++n) {
        if (!usable(cloud.state[n])) continue;
        any = true;
        for (std::size_t c = 0; c < channels; ++c)
            if (!std::isfinite(cloud.at(n)[c]))
                throw Error("malformed_measurement",
                            where + "has a value that is no finite number (point " +
                                std::to_string(n) + ")");
    }
    if (!any) throw Error("malformed_measurement", where + "has no usable point");
}

}  // namespace

Reading read_measurement(std::string_view bytes, const ReadOptions& options) {
    if (bytes.size() > kFileBytesMax)
        throw Error("measurement_too_large", "the file has " + std::to_string(bytes.size()) +
                                                 " bytes, at most " +
                                                 std::to_string(kFileBytesMax) + " are read");
    for (const Reader& reader : readers()) {
        if (!reader.recognises(bytes)) continue;
        Reading reading = reader.read(bytes, options);
        reading.understood.format = reader.name;
        if (reading.components.empty())
            throw Error("malformed_measurement", "the file holds no measurement");
        for (const Component& part : reading.components) check_component(part);
        return reading;
    }
    refuse_known(bytes);
    std::string known;
    for (const Reader& reader : readers())
        known += std::string(known.empty() ? "" : "; ") + std::string(reader.description);
    throw Error("unknown_measurement", "the content is of no format that is read: " + known);
}

void Understood::found(std::string what, std::string value, std::string evidence) {
    if (findings.size() < kRemarksMax)
        findings.push_back({std::move(what), std::move(value), std::move(evidence)});
}

void Understood::leave_out(std::string what, std::string why) {
    if (left_out.size() < kRemarksMax) left_out.push_back({std::move(what), std::move(why)});
}

void Understood::warn(std::string text) {
    if (warnings.size() < kRemarksMax) warnings.push_back(std::move(text));
}

std::string plain_text(std::string_view text) {
    constexpr std::size_t kMost = 120;
    std::string out;
    for (const char c : text.substr(0, kMost)) out += c >= ' ' && c <= '~' ? c : '?';
    return text.size() > kMost ? out + "..." : out;
}

std::string in_words(double value) {
    char text[40];
    std::snprintf(text, sizeof text, "%.6g", value);
    return text;
}

}  // namespace kiln::measured
