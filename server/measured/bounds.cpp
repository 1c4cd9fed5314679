// SPDX-License-Identifier: Apache-2.0
#include "server/measured/bounds.h"

namespace kiln::measured {

Bounds measured_bounds() {
    return {
        {"measurement_bytes_max", kFileBytesMax, "B", "Of a measured file."},
        {"measurement_points_max", kPointsMax, "points", "Of a measured file."},
        {"measurement_channels_max", kChannelsMax, "channels", "Of a measured file."},
        {"measurement_values_max", kValuesMax, "values", "Points times channels of a file."},
        {"measurement_line_bytes_max", kLineBytesMax, "B", "A line of a measured text file."},
        {"measurement_document_bytes_max", kDocumentBytesMax, "B",
         "A measured file in JSON or XML, which is parsed as a whole."},
        {"measurement_xml_tags_max", kXmlTagsMax, "tags", "Of a measured file in XML."},
        {"measurement_components_max", kComponentsMax, "components",
         "Sides, directions and spectra in one measured file."},
        {"measurement_remarks_max", kRemarksMax, "remarks",
         "Findings, warnings and things left out, of each kind, in the account of a file."},
    };
}

}  // namespace kiln::measured
