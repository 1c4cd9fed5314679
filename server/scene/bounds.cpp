// SPDX-License-Identifier: Apache-2.0
#include "server/scene/bounds.h"

namespace kiln {

Bounds scene_bounds() {
    return {
        {"scene_values_max", kSceneValuesMax, "values", "Most JSON values of a scene."},
        {"scene_materials_max", kSceneMaterialsMax, "materials", "Most used materials of a scene."},
        {"scene_name_bytes_max", kSceneNameBytesMax, "bytes",
         "Of a material's name; longer ones are cut."},
        {"image_texels_max", kImageTexelsMax, "texels",
         "Largest image of a scene that is looked into."},
        {"scene_texels_max", kSceneTexelsMax, "texels",
         "The same, of all images of one scene together."},
        {"scene_image_bytes_max", kSceneImageBytesMax, "bytes",
         "Of the files of all images of one scene that are looked into."},
        {"image_memory_bytes_max", kImageMemoryBytesMax, "bytes",
         "What looking into one image may allocate."},
        {"image_scans_max", kImageScansMax, "scans", "Of a progressive JPEG that is looked into."},
        {"rows_max", kRowsMax, "rows",
         "Isolated roughnesses of a scene that get a row each; more become a range."},
    };
}

}  // namespace kiln
