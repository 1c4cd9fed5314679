// SPDX-License-Identifier: Apache-2.0
#include "server/measured/readers.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>

#include "server/base/error.h"
#include "server/measured/bounds.h"
#include "server/measured/colour.h"

namespace kiln::measured {

const std::vector<Reader>& readers() {
    static const std::vector<Reader> rows = {
        {"rgl", "RGL/EPFL tensor file, rgb or spectra", is_rgl, read_rgl},
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
            if (const auto value = cloud.at(n)[c]; !std::isfinite(value))
                throw Error("malformed_measurement",
                            where + "has a value that " +
                                (std::isinf(value) ? "exceeds the range of float, 3.4e38"
                                                   : "is no number") +
                                " (point " + std::to_string(n) + ")");
    }
    if (!any) throw Error("malformed_measurement", where + "has no usable point");
}

bool says(const Understood& account, std::string_view what) {
    return std::any_of(account.findings.begin(), account.findings.end(),
                       [what](const Finding& one) { return one.what == what; });
}

/// What R, G and B of a table are made of, where the reader has not said it.
void explain_colour(Reading& reading) {
    Understood& account = reading.understood;
    if (says(account, "colour")) return;
    const std::vector<std::string>& channels = reading.components.front().cloud.channels;
    std::string names;
    for (std::size_t n = 0; n < std::min<std::size_t>(channels.size(), 8); ++n)
        names += (n > 0 ? ", " : "") + channels[n];
    const std::string evidence = "the channels " + names + (channels.size() > 8 ? ", ..." : "");
    try {
        account.found("colour", colouring_of(channels).words, evidence);
    } catch (const Error& error) {
        account.found("colour", "none", evidence);
    }
}

/// What no line of a file speaks of, its points do.
void explain_points(Reading& reading) {
    Understood& account = reading.understood;
    const Cloud& cloud = reading.components.front().cloud;
    if (!says(account, "symmetry")) {
        std::set<std::pair<long, long>> lights;
        std::set<long> thetas;
        for (std::size_t n = 0; n < cloud.size() && lights.size() <= kIncidencesMax; ++n) {
            const long theta = std::lround(1000.0 * cloud.theta_i[n]);
            lights.emplace(theta, std::lround(1000.0 * cloud.phi_i[n]));
            thetas.insert(theta);
        }
        const bool one = lights.size() == thetas.size();
        account.found("symmetry", one ? "isotropic" : "none",
                      one ? "one azimuth of the light under each theta_in"
                          : "several azimuths of the light under one theta_in");
    }
    if (!says(account, "mask")) {
        const auto whole = std::all_of(cloud.state.begin(), cloud.state.end(), usable);
        account.found("mask", whole ? "none" : "points that cannot be",
                      whole ? "every value counts as measured"
                            : "below the horizon, incomplete, or impossible");
    }
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
        explain_colour(reading);
        explain_points(reading);
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
