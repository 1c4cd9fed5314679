// SPDX-License-Identifier: Apache-2.0
#include "server/measured/bounds.h"

#include "server/compute/measured_launch.h"

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
        {"measurement_axis_angles_max", kAxisAnglesMax, "angles", "On one axis of a text file."},
        {"measurement_blocks_max", kBlocksMax, "blocks", "Of values in a text file."},
        {"measurement_patches_max", kPatchesMax, "patches", "Of an angle basis in XML."},
        {"measurement_preface_lines_max", kPrefaceLinesMax, "lines",
         "Before the line of a text file that names its columns."},
        {"measurement_tensor_fields_max", kTensorFieldsMax, "fields", "Of a tensor file."},
        {"measurement_tensor_name_bytes_max", kTensorNameBytesMax, "B", "Name of such a field."},
        {"measurement_tensor_dimensions_max", kTensorDimensionsMax, "dimensions",
         "Of such a field."},
        {"measurement_wavelength_step_max", kWavelengthStepMax, "nm",
         "Between wavelengths of a spectral file, from 400 to 700."},
        {"measurement_incidences_max", kIncidencesMax, "directions",
         "Of light in one component of a file."},
        {"measurement_surveyed_incidences_max", kSurveyedIncidencesMax, "directions",
         "Of light that the account of a component lists."},
        {"measurement_table_nodes_max", kMeasuredNodesMax, "nodes",
         "Of the regular form that kernels read."},
    };
}

}  // namespace kiln::measured
