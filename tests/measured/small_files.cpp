// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdint>
#include <cstring>
#include <numbers>
#include <numeric>
#include <stdexcept>

#include "server/measured/readers.h"
#include "tests/measured/fuzz_targets.h"
#include "tests/measured/synthetic.h"

namespace kiln::synthetic {
namespace {

template <typename T>
void put(std::string& bytes, T value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

/// Three theta_i, the last a copy, four by four nodes: colours under three azimuths of a quadrant,
/// or wavelengths every 25 nm under one.
std::string small_rgl(bool spectral) {
    const auto floats = [](std::size_t count, auto value) {
        std::string data;
        for (std::size_t n = 0; n < count; ++n) put(data, static_cast<float>(value(n)));
        return data;
    };
    const auto one = [](std::size_t) { return 1.0; };
    const std::size_t planes = spectral ? 13 : 3, azimuths = spectral ? 1 : 3;
    const std::size_t slice = planes * 16;
    std::vector<TensorPart> parts = {
        {"description", 1, {4}, "test"},
        {"phi_i",
         10,
         {azimuths},
         floats(
             azimuths,
             [](std::size_t n) { return std::numbers::pi * (0.25 * static_cast<double>(n) - 1); })},
        {"theta_i",
         10,
         {3},
         floats(3, [](std::size_t n) { return 0.75 * static_cast<double>(n); })},
        {"sigma", 10, {2, 4}, floats(8, one)},
        {"ndf", 10, {2, 4}, floats(8, one)},
        {"vndf", 10, {azimuths, 3, 4, 4}, floats(azimuths * 48, one)},
        {spectral ? "spectra" : "rgb",
         10,
         {azimuths, 3, planes, 4, 4},
         floats(azimuths * 3 * slice,
                [&](std::size_t n) {
                    const bool copy = n / slice % 3 == 2;
                    return 0.01 * static_cast<double>(copy ? n - slice : n);
                })},
        {"jacobian", 1, {1}, std::string(1, '\1')},
        {"valid", 1, {azimuths * 6}, std::string(azimuths * 6, '\xff')},
    };
    if (spectral)
        parts.push_back({"wavelengths", 10, {planes}, floats(planes, [](std::size_t n) {
                             return 400 + 25 * static_cast<double>(n);
                         })});
    return tensor_file(parts);
}

std::string small_xml() {
    const auto block = [](const char* low, const char* high, const char* theta, const char* phis) {
        return std::string("<AngleBasisBlock><Theta>") + theta +
               "</Theta><ThetaBounds><LowerTheta>" + low + "</LowerTheta><UpperTheta>" + high +
               "</UpperTheta></ThetaBounds><nPhis>" + phis + "</nPhis></AngleBasisBlock>";
    };
    std::string text =
        "<?xml "
        "version=\"1.0\"?><WindowElement><Optical><Layer><Material><Name>test</Name></Material>"
        "<DataDefinition><IncidentDataStructure>Columns</IncidentDataStructure><AngleBasis>" +
        block("0", "45", "0", "1") + block("45", "90", "60", "3") +
        "</AngleBasis></DataDefinition><WavelengthData><Wavelength unit=\"Integral\">Visible"
        "</Wavelength><WavelengthDataBlock><WavelengthDataDirection>Reflection Front"
        "</WavelengthDataDirection><ScatteringData>";
    for (int n = 0; n < 16; ++n) text += std::to_string(0.1 + 0.01 * n) + ",\t";
    return text +
           "</ScatteringData></WavelengthDataBlock></WavelengthData></Layer></Optical>"
           "</WindowElement>";
}

constexpr measured::MerlSizes kSmallMerl = {6, 6, 8};

/// A table of 288 cells, every seventh not measured.
std::string small_merl() {
    std::string bytes;
    for (const std::size_t size : {kSmallMerl.theta_h, kSmallMerl.theta_d, kSmallMerl.half_turn})
        put(bytes, static_cast<std::int32_t>(size));
    for (int n = 0; n < 3 * 6 * 6 * 8; ++n) put(bytes, n % 7 == 0 ? -1.0 : 100.0 + n);
    return bytes;
}

/// Zeros but for the sizes: as short as a file may be that asks for 35 MB.
std::string short_merl() {
    std::string bytes;
    for (const std::int32_t size : {90, 90, 180}) put(bytes, size);
    return bytes + std::string(4096, '\0');
}

constexpr const char* kZemax =
    "# a comment\nSource\tMeasured\nSymmetry\tPlaneSymmetrical\nSpectralContent\tMonochrome\n"
    "ScatterType\tBRDF\nSampleRotation\t1\n0\nAngleOfIncidence\t2\n10\t50\nScatterAzimuth\t3\n"
    "0\t90\t180\nScatterRadial\t3\n0\t20\t60\n\nMonochrome\nDataBegin\nTIS\t0.04\n"
    "3e-2\t2e-2\t1e-2\n3e-2\t2e-2\t1e-2\n3e-2\t2e-2\t0\nTIS\t0.05\n5e-2\t2e-2\t1e-2\n"
    "5e-2\t2e-2\t1e-2\n5e-2\t2e-2\t0\nDataEnd\n";
constexpr const char* kFred =
    "type bsdf_data\nformat angles=deg bsdf=value scale=1\n10 0\n0 0 0.03\n5 0 0.034\n5 90 0.033\n"
    "10 10 0.031\n50,0\n0 0 0.01\n20\t90\t0.012\n50 0 0.2\n-20 0 0.011\n";
constexpr const char* kAstm =
    "E1392 TEST\nSAMPLE paint\nNUM_POINTS 4\nVARS theta_i,phi_i,theta_s,phi_s,R,G,B\n"
    "0.5,0,0.5,3.14,0.3,0.2,0.1\n0.5,0,0.2,1.0,0.2,0.1,0.1\n0.5,0,1.2,2.0,0.2,0.1,-0.01\n"
    "0.2,0,0.5,1.0,0.21,0.11,0.1\n";
constexpr const char* kBird =
    "{\"metadata\":{\"sample\":{\"name\":\"SRT\"}},\"data\":{\"wavelength_i\":{\"unit\":\"nm\","
    "\"values\":[550,550,650,650]},\"theta_i\":{\"unit\":\"deg\",\"values\":[0,0,0,0]},\"phi_i\":{"
    "\"unit\":\"deg\",\"values\":[0,0,0,0]},\"theta_r\":{\"unit\":\"deg\",\"values\":[10,20,10,20]}"
    ","
    "\"phi_r\":{\"unit\":\"deg\",\"values\":[60,60,60,60]},\"BRDF\":{\"unit\":\"1/sr\",\"values\":"
    "[0.25,0.26,0.27,0.28]}}}";
constexpr const char* kCsv =
    "theta_in,phi_in,theta_out,phi_out,r,g,b\n30,0,30,180,0.5,0.4,0.3\n30,0,10,90,0.3,0.2,0.1\n"
    "30,0,60,200,0.3,0.2,0.1\n60,0,60,180,0.9,0.8,0.7\n";

}  // namespace

std::string small_file(std::string_view reader) {
    if (reader == "merl") return short_merl();
    if (reader == "rgl") return small_rgl(false);
    if (reader == "rgl_spectra") return small_rgl(true);
    if (reader == "lbnl_xml") return small_xml();
    if (reader == "zemax") return kZemax;
    if (reader == "fred") return kFred;
    if (reader == "astm") return kAstm;
    if (reader == "bird_json") return kBird;
    if (reader == "csv") return kCsv;
    if (reader == "lighttools") {
        MiniDiffGrid grid;
        grid.aoi = {0, 60};
        grid.azimuth_step = 90;
        grid.radial_step = 25;
        return minidiff_file(ggx(0.4, {0.1, 0.1, 0.1}, {0.5, 0.4, 0.3}), grid);
    }
    throw std::invalid_argument("no small file of that format");
}

}  // namespace kiln::synthetic

namespace kiln {

std::vector<FuzzTarget> fuzz_targets() {
    // One reader with two kinds of file.
    std::vector<FuzzTarget> targets = {
        {"rgl_spectra", synthetic::small_file("rgl_spectra"), [](std::string_view bytes) {
             return measured::read_rgl(bytes, measured::ReadOptions{});
         }}};
    for (const measured::Reader& reader : measured::readers())
        if (reader.name == "merl")
            targets.push_back({reader.name, synthetic::small_merl(), [](std::string_view bytes) {
                                   return measured::read_merl_of(bytes, synthetic::kSmallMerl);
                               }});
        else
            targets.push_back({reader.name, synthetic::small_file(reader.name),
                               [&reader](std::string_view bytes) {
                                   return reader.read(bytes, measured::ReadOptions{});
                               }});
    return targets;
}

}  // namespace kiln
