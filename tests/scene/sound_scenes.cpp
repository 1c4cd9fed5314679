// SPDX-License-Identifier: Apache-2.0
#include "tests/scene/scenes.h"

namespace kiln::test {

std::vector<std::string> sound_scenes() {
    const std::string png = png_of(4, 4, std::vector<unsigned char>(64, 99));
    const std::string jpeg = jpeg_of(8, 8, std::vector<unsigned char>(256, 50));
    const std::string textured = R"({"name":"x","pbrMetallicRoughness":{"baseColorFactor":[1,1,1,1],
        "metallicRoughnessTexture":{"index":0},"baseColorTexture":{"index":1}},"extensions":{
        "KHR_materials_sheen":{"sheenColorFactor":[1,0,0],"sheenRoughnessFactor":0.5},
        "KHR_materials_clearcoat":{"clearcoatFactor":1,"clearcoatRoughnessFactor":0.1},
        "KHR_materials_ior":{"ior":1.4},"KHR_materials_specular":{"specularFactor":0.5}}})";
    const std::string binary = png + jpeg;
    const std::string views =
        R"("textures":[{"source":0},{"source":1}],"images":[{"bufferView":0},{"bufferView":1}],)"
        R"("bufferViews":[{"buffer":0,"byteLength":)" +
        std::to_string(png.size()) + R"(},{"buffer":0,"byteOffset":)" + std::to_string(png.size()) +
        R"(,"byteLength":)" + std::to_string(jpeg.size()) + R"(}],"buffers":[{"byteLength":)" +
        std::to_string(binary.size()) + "}],";
    return {glb_of(scene_of(textured, views), binary),
            scene_of(R"({"pbrMetallicRoughness":{"metallicRoughnessTexture":{"index":0}}})",
                     R"("textures":[{"source":0}],"images":[{"uri":"data:image/png;base64,)" +
                         base64(png) + "\"}],"),
            R"({"materials":[{"name":"a","lobes":["metal","sheen"],"roughness":[0.2,0.4],)"
            R"("sheen_roughness":0.5,"metal_f0":[1,0.5,0.2]},{"measured":")" +
                measurement('0') + R"(","used":false},{"measured":")" + measurement('1') + "\"}]}"};
}

}  // namespace kiln::test
