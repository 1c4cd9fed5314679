// SPDX-License-Identifier: Apache-2.0
#include "server/scene/scene.h"

#include <nlohmann/json.hpp>

#include "server/scene/bounds.h"
#include "server/scene/container.h"
#include "server/scene/gltf.h"
#include "server/scene/gltf_document.h"
#include "server/scene/material_list.h"
#include "server/spec/json_text.h"
#include "server/spec/limits.h"

namespace kiln {

namespace {

constexpr std::array<std::string_view, kLobeCount> kLobeWords = {
    "metal",     "dielectric",   "specular_glossiness",  "diffuse",    "sheen",
    "clearcoat", "transmission", "diffuse_transmission", "anisotropy", "iridescence"};
constexpr std::array<std::string_view, 4> kOriginWords = {"factor", "texels", "texture",
                                                          "animation"};

std::string summary(const std::vector<Problem>& problems) {
    if (problems.empty()) return "the scene is not valid";
    const Problem& first = problems.front();
    const std::string place = first.pointer.empty() ? "the document" : in_quotes(first.pointer);
    if (problems.size() == 1) return "the scene is not valid: " + place + " " + first.message;
    return "the scene has " + std::to_string(problems.size()) + " problems; the first: " + place +
           " " + first.message;
}

}  // namespace

std::string_view to_word(Lobe lobe) { return kLobeWords[static_cast<std::size_t>(lobe)]; }

std::optional<Lobe> lobe_from(std::string_view word) {
    for (std::size_t i = 0; i < kLobeCount; ++i)
        if (kLobeWords[i] == word) return static_cast<Lobe>(i);
    return std::nullopt;
}

std::string_view to_word(Origin origin) { return kOriginWords[static_cast<std::size_t>(origin)]; }

InvalidScene::InvalidScene(std::vector<Problem> found)
    : Error("invalid_scene", summary(found)), problems(std::move(found)) {}

std::string short_name(std::string name) {
    if (name.size() <= kSceneNameBytesMax) return name;
    std::size_t end = kSceneNameBytesMax;
    while (end > 0 && (name[end] & 0xC0) == 0x80) --end;  // not within a UTF-8 sequence
    name.resize(end);
    return name;
}

std::string measured_pointer(const SceneUse& scene, const MaterialUse& material) {
    const std::string place = "/materials/" + std::to_string(material.index.value_or(0));
    return scene.format == "materials" ? place + "/measured"
                                       : place + "/extras/" + kMeasuredProperty;
}

SceneUse read_scene(std::string_view bytes, const SceneChoice& choice) {
    const auto bytes_max = static_cast<std::size_t>(limits().scene_bytes_max);
    if (bytes.size() > bytes_max) {
        const std::string message = "has " + std::to_string(bytes.size()) +
                                    " bytes; allowed: at most " + std::to_string(bytes_max);
        throw Malformed("the scene " + message, {{"", message}});
    }
    const Container container = open_container(bytes);
    nlohmann::json document =
        parse_json(container.json, {.bytes_max = limits().scene_bytes_max,
                                    .depth_max = limits().depth_max,
                                    .values_max = static_cast<std::int64_t>(kSceneValuesMax)});
    ProblemList problems(static_cast<std::size_t>(limits().problems_max));
    SceneUse scene;
    if (!document.is_object()) {
        problems.add("", "must be an object: a glTF 2.0 document, or {\"materials\": […]}");
    } else if (container.is_glb || document.contains("asset")) {
        const tinygltf::Model model = open_gltf(std::move(document), problems);
        if (problems.empty()) scene = read_gltf(model, container.binary, choice, problems);
        scene.format = container.is_glb ? "glb" : "gltf";
    } else {
        scene = read_material_list(document, problems);
        if (!choice.scene.empty() || !choice.variant.empty())
            problems.add("", "is a list of materials, which has no scenes and no variants");
    }
    if (!problems.empty()) throw InvalidScene(problems.take());
    return scene;
}

}  // namespace kiln
