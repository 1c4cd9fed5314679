// SPDX-License-Identifier: Apache-2.0
#include "server/scene/gltf_document.h"

#include <nlohmann/json.hpp>

#include "server/spec/contract.h"
#include "server/spec/json_text.h"
#include "server/spec/limits.h"

namespace kiln {

namespace {

using Json = nlohmann::json;

/// The entries of a list that the library would look into at once.
Json take(Json& document, const char* name) {
    const auto found_list = document.find(name);
    if (found_list == document.end()) return Json::array();
    Json list = std::move(*found_list);
    document.erase(found_list);
    return list;
}

/// The library's primitives and channels take hundreds of bytes each: all lists of them together
/// are bounded as any one list is.
void bound(const Json& owners, const char* member, const std::string& pointer,
           ProblemList& problems) {
    const auto most = static_cast<std::size_t>(limits().scene_entries_max);
    std::size_t count = 0;
    for (const Json& owner : owners)
        if (const auto list = owner.find(member); list != owner.end()) count += list->size();
    if (count > most)
        problems.add(pointer, "has " + std::to_string(count) + " " + member +
                                  " altogether; allowed: at most " + std::to_string(most));
}

std::vector<tinygltf::Image> unopened_images(const Json& list) {
    std::vector<tinygltf::Image> images(list.size());
    for (std::size_t i = 0; i < images.size(); ++i) {
        images[i].uri = list[i].value("uri", "");
        images[i].bufferView = list[i].value("bufferView", -1);
    }
    return images;
}

std::vector<tinygltf::Buffer> unopened_buffers(const Json& list) {
    std::vector<tinygltf::Buffer> buffers(list.size());
    for (std::size_t i = 0; i < buffers.size(); ++i) buffers[i].uri = list[i].value("uri", "");
    return buffers;
}

}  // namespace

// tinygltf 2.7 takes a value of the wrong type for one that is not there, drops primitives and
// animations that lack a member, names no place, follows extras as deep as they go on the stack,
// and gives up where a buffer is elsewhere. So it sees what the schema lets through.
tinygltf::Model open_gltf(Json document, ProblemList& problems) {
    tinygltf::Model model;
    const Json& schema = contract()["components"]["schemas"]["Gltf"];
    Json structure = project_schema(contract(), schema, document, problems);
    if (!problems.empty()) return model;
    bound(structure.value("meshes", Json::array()), "primitives", "/meshes", problems);
    bound(structure.value("animations", Json::array()), "channels", "/animations", problems);
    if (!problems.empty()) return model;
    document = nullptr;
    const Json images = take(structure, "images"), buffers = take(structure, "buffers");
    const std::string text = structure.dump();
    structure = nullptr;
    tinygltf::TinyGLTF library;
    std::string error, warning;
    if (!library.LoadASCIIFromString(&model, &error, &warning, text.data(),
                                     static_cast<unsigned>(text.size()), ""))
        problems.add("", "is refused by the glTF library: " + in_quotes(error));
    model.images = unopened_images(images);
    model.buffers = unopened_buffers(buffers);
    return model;
}

}  // namespace kiln
