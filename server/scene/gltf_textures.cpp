// SPDX-License-Identifier: Apache-2.0
#include "server/scene/bounds.h"
#include "server/scene/gltf.h"
#include "server/spec/json_text.h"

namespace kiln {

namespace {

/// What a data: URI of glTF holds: an image, or a buffer.
std::optional<std::string> data_uri_bytes(const std::string& uri) {
    std::vector<unsigned char> bytes;
    std::string media_type;
    if (!tinygltf::DecodeDataURI(&bytes, media_type, uri, 0, false)) return std::nullopt;
    // The library stops at what is no base64 and says nothing.
    const std::size_t digits = uri.find_last_not_of('=') - uri.find(',');
    if (bytes.size() != digits * 3 / 4) return std::nullopt;
    return std::string(bytes.begin(), bytes.end());
}

constexpr const char* kBadDataUri = "a data: URI without good base64 of a type that glTF has";

std::string place(const char* list, std::size_t index) {
    return join_pointer(list, std::to_string(index));
}

}  // namespace

std::optional<std::size_t> index_among(int index, std::size_t count, const char* what,
                                       const std::string& pointer, ProblemList& problems) {
    if (index >= 0 && static_cast<std::size_t>(index) < count)
        return static_cast<std::size_t>(index);
    problems.add(pointer, "is " + std::to_string(index) + "; must be the index of one of " +
                              std::to_string(count) + " " + what);
    return std::nullopt;
}

GltfTextures::GltfTextures(const tinygltf::Model& model, std::string_view binary,
                           ProblemList& problems)
    : model_(model),
      binary_(binary),
      problems_(problems),
      texels_left_(kSceneTexelsMax),
      bytes_left_(kSceneImageBytesMax) {}

TextureLook GltfTextures::look(int index, const std::string& pointer) {
    if (index < 0) return {};
    TextureLook result{true, {}, ""};
    const auto texture = index_among(index, model_.textures.size(), "textures", pointer, problems_);
    if (!texture) return result;
    const int source = model_.textures[*texture].source;
    const bool other = !model_.textures[*texture].extensions.empty();
    if (source < 0 || other) {
        result.why_not = "texture " + std::to_string(*texture) +
                         (other ? " has an image in another format, which may differ"
                                : " names no PNG or JPEG that every program reads");
        return result;
    }
    const auto image = index_among(source, model_.images.size(), "images",
                                   place("/textures", *texture) + "/source", problems_);
    if (!image) return result;
    auto found_look = looks_.find(*image);
    if (found_look == looks_.end()) found_look = looks_.emplace(*image, look_at(*image)).first;
    result.texels = found_look->second.texels;
    if (!result.texels)
        result.why_not = "image " + std::to_string(*image) + " " + found_look->second.why_not;
    return result;
}

ImageLook GltfTextures::look_at(std::size_t index) {
    const tinygltf::Image& image = model_.images[index];
    if (!image.uri.empty()) {
        if (!image.uri.starts_with("data:"))
            return {{}, "(" + in_quotes(image.uri) + ") is not in the document"};
        const auto bytes = data_uri_bytes(image.uri);
        if (!bytes) return {{}, std::string("is ") + kBadDataUri};
        return look_at_bytes(*bytes);
    }
    if (image.bufferView < 0) return {{}, "is neither a URI nor a part of a buffer"};
    std::string why;
    if (const auto view = index_among(image.bufferView, model_.bufferViews.size(), "bufferViews",
                                      place("/images", index) + "/bufferView", problems_)) {
        if (const auto bytes = view_bytes(*view, why)) return look_at_view(*bytes);
    }
    return {{}, why};
}

/// Images may share their bytes.
ImageLook GltfTextures::look_at_view(std::string_view bytes) {
    const auto known = views_.find({bytes.data(), bytes.size()});
    if (known != views_.end()) return known->second;
    return views_[{bytes.data(), bytes.size()}] = look_at_bytes(bytes);
}

ImageLook GltfTextures::look_at_bytes(std::string_view bytes) {
    if (bytes.size() > bytes_left_)
        return {{},
                "comes after " + std::to_string(kSceneImageBytesMax) +
                    " bytes of images, beyond which none of a scene is looked into"};
    bytes_left_ -= bytes.size();
    return look_at_image(bytes, texels_left_);
}

std::optional<std::string_view> GltfTextures::view_bytes(std::size_t index, std::string& why) {
    const tinygltf::BufferView& view = model_.bufferViews[index];
    const std::string pointer = place("/bufferViews", index);
    const auto buffer =
        index_among(view.buffer, model_.buffers.size(), "buffers", pointer + "/buffer", problems_);
    if (!buffer) return std::nullopt;
    const auto bytes = buffer_bytes(*buffer, why);
    if (!bytes) return std::nullopt;
    if (view.byteOffset > bytes->size() || view.byteLength > bytes->size() - view.byteOffset) {
        problems_.add(pointer, "bytes " + std::to_string(view.byteOffset) + " and " +
                                   std::to_string(view.byteLength) +
                                   " more go past the end of its buffer, which has " +
                                   std::to_string(bytes->size()));
        return std::nullopt;
    }
    return bytes->substr(view.byteOffset, view.byteLength);
}

std::optional<std::string_view> GltfTextures::buffer_bytes(std::size_t index, std::string& why) {
    const std::string& uri = model_.buffers[index].uri;
    if (uri.empty()) {
        if (index == 0 && !binary_.empty()) return binary_;
        why = "lies in a buffer without data";
        return std::nullopt;
    }
    auto known = decoded_.find(index);
    if (known == decoded_.end()) known = decoded_.emplace(index, data_uri_bytes(uri)).first;
    if (known->second) return *known->second;
    why = uri.starts_with("data:") ? std::string("lies in ") + kBadDataUri
                                   : "lies in " + in_quotes(uri) + ", not in the document";
    return std::nullopt;
}

}  // namespace kiln
