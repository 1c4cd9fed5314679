// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "server/scene/bounds.h"
#include "server/scene/gltf.h"
#include "server/spec/json_text.h"

namespace kiln {

GltfTextures::GltfTextures(const Place& root, std::string_view binary)
    : textures_(root.list("textures", kSceneEntriesMax)),
      images_(root.list("images", kSceneEntriesMax)),
      views_(root.list("bufferViews", kSceneEntriesMax)),
      buffers_(root.list("buffers", kSceneEntriesMax)),
      binary_(binary),
      texels_left_(kSceneTexelsMax) {}

TextureLook GltfTextures::look(const Place& owner, const char* name) {
    const Place info = owner.object(name);
    if (!info) return {};
    TextureLook result{true, {}, ""};
    const auto texture_index = info.index("index", textures_.size(), "textures");
    if (!texture_index) {
        if (!info.has("index")) info.refuse("names no texture: index is required");
        return result;
    }
    const Place texture = textures_.item(*texture_index);
    const auto image = texture.index("source", images_.size(), "images");
    if (!image) {
        result.why_not = "texture " + std::to_string(*texture_index) +
                         " names no PNG or JPEG that every program reads";
        return result;
    }
    auto found_look = looks_.find(*image);
    if (found_look == looks_.end()) found_look = looks_.emplace(*image, look_at(*image)).first;
    result.texels = found_look->second.texels;
    if (!result.texels)
        result.why_not = "image " + std::to_string(*image) + " " + found_look->second.why_not;
    return result;
}

ImageLook GltfTextures::look_at(std::size_t index) {
    const Place image = images_.item(index);
    std::string why = "is neither a URI nor a part of a buffer";
    if (const std::string* uri = image.text_at("uri")) {
        if (!uri->starts_with("data:"))
            return {{}, "(" + in_quotes(*uri) + ") is not in the document"};
        const auto bytes = data_uri_bytes(*uri);
        if (!bytes) return {{}, "is a data: URI without good base64"};
        return look_at_image(*bytes, texels_left_);
    }
    if (const auto view = image.index("bufferView", views_.size(), "bufferViews")) {
        if (const auto bytes = view_bytes(*view, why)) return look_at_image(*bytes, texels_left_);
    }
    return {{}, why};
}

std::optional<std::string_view> GltfTextures::view_bytes(std::size_t index, std::string& why) {
    const Place view = views_.item(index);
    const auto buffer = view.index("buffer", buffers_.size(), "buffers");
    const std::size_t offset = view.bytes("byteOffset").value_or(0);
    const auto length = view.bytes("byteLength");
    if (!buffer || !length) {
        if (!view.has("buffer") || !view.has("byteLength"))
            view.refuse("must have buffer and byteLength");
        return std::nullopt;
    }
    const auto bytes = buffer_bytes(*buffer, why);
    if (!bytes) return std::nullopt;
    if (offset > bytes->size() || *length > bytes->size() - offset) {
        view.refuse("bytes " + std::to_string(offset) + " and " + std::to_string(*length) +
                    " more go past the end of its buffer, which has " +
                    std::to_string(bytes->size()));
        return std::nullopt;
    }
    return bytes->substr(offset, *length);
}

std::optional<std::string_view> GltfTextures::buffer_bytes(std::size_t index, std::string& why) {
    const Place buffer = buffers_.item(index);
    const std::string* uri = buffer.text_at("uri");
    if (uri == nullptr) {
        if (index == 0 && !binary_.empty()) return binary_;
        why = "lies in a buffer without data";
        return std::nullopt;
    }
    const auto known = decoded_.find(index);
    if (known != decoded_.end()) return known->second;
    if (auto bytes = data_uri_bytes(*uri))
        return decoded_.emplace(index, std::move(*bytes)).first->second;
    why = uri->starts_with("data:") ? "lies in a data: URI without good base64"
                                    : "lies in " + in_quotes(*uri) + ", not in the document";
    return std::nullopt;
}

}  // namespace kiln
