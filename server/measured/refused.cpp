// SPDX-License-Identifier: Apache-2.0
// Files that people have beside their measurements: known by content, and why they are not read.
#include <array>

#include "server/base/error.h"
#include "server/measured/readers.h"
#include "server/measured/text_scan.h"

namespace kiln::measured {
namespace {

struct Known {
    std::string_view start;  ///< of the file, or of a line of its first 64 KiB if in_line
    bool in_line;
    std::string_view what, why;
};

constexpr std::array<Known, 11> kKnown = {{
    {"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1", false, "an Excel 97 workbook",
     "raw readings of an instrument need its calibration; export a table as CSV"},
    {"PK\x03\x04", false, "a ZIP archive or an Excel workbook", "export a table as CSV"},
    {"SCATFUN", false, "a Fourier BSDF of Mitsuba or pbrt",
     "it is a fit in a Fourier basis, not a measurement"},
    {"NVIDIA ARC MBSDF V1", false, "an MDL .mbsdf file", "its order of axes is not documented"},
    {"OPTIS", false, "a Speos surface file",
     "its values are relative to a percentage that only "
     "Speos defines"},
    {"Data file type", true, "an instrument export of the REFLET family",
     "its values are raw intensities; they need the calibration of the instrument"},
    {"DataType:", true, "an instrument export of the RT-300S family",
     "its values are raw intensities; they need the calibration of the instrument"},
    {"REFERENCES:", true, "optical constants of refractiveindex.info",
     "no reflectance; use them in the job's fresnel field"},
    {"wavelength_nm,xbar", true, "colour-matching functions", "no reflectance"},
    {"# BSDF fits", true, "fitted parameters", "a fit is not a measurement"},
    {"\x76\x2f\x31\x01", false, "an OpenEXR image", "images are written, never read"},
}};

}  // namespace

void refuse_known(std::string_view bytes) {
    if (bytes.empty()) throw Error("unreadable_measurement", "the file is empty");
    for (const Known& known : kKnown)
        if (known.in_line ? line_starts(bytes, known.start) : bytes.starts_with(known.start))
            throw Error("unreadable_measurement",
                        "this is " + std::string(known.what) + ": " + std::string(known.why));
    const std::size_t first = bytes.find_first_not_of(" \t\r\n");
    if (first != bytes.npos && bytes[first] == '{')
        throw Error("unreadable_measurement",
                    "this begins as JSON, but theta_i and BRDF of BiRD's universal format are not "
                    "both in it; it may have been cut off");
}

}  // namespace kiln::measured
