// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>

#include "server/scene/container.h"
#include "server/scene/scene.h"
#include "server/scene/texels.h"
#include "server/scene/walk.h"

namespace kiln {

/// A texture that a material names.
struct TextureLook {
    bool present = false;
    std::optional<Texels> texels;
    std::string why_not;  ///< where the texels are not known: a sentence's end
};

/// Images of one glTF document, looked into at most once each, and only where a used material reads
/// them.
class GltfTextures {
  public:
    GltfTextures(const Place& root, std::string_view binary);
    /// The texture info `name` of a material or extension.
    TextureLook look(const Place& owner, const char* name);

  private:
    ImageLook look_at(std::size_t image);
    /// Empty with `why` where the bytes are not in the document.
    std::optional<std::string_view> view_bytes(std::size_t view, std::string& why);
    std::optional<std::string_view> buffer_bytes(std::size_t buffer, std::string& why);

    Place textures_, images_, views_, buffers_;
    std::string_view binary_;
    std::uint64_t texels_left_;
    std::map<std::size_t, ImageLook> looks_;
    std::map<std::size_t, std::string> decoded_;  ///< of buffers in data: URIs
};

/// The custom property (member of a material's extras) that names measured data in its place.
inline constexpr const char* kMeasuredProperty = "kiln_measured";
/// Its id, "" where there is none.
std::string measured_of_gltf(const Place& material);

/// JSON pointers of the numbers that an animation moves (KHR_animation_pointer).
std::set<std::string> animated_numbers(const Place& root);

/// What a glTF material asks for; `vertex_colours`: a primitive of it has COLOR_0.
MaterialUse read_gltf_material(const Place& material, GltfTextures& textures,
                               const std::set<std::string>& animated, bool vertex_colours);

/// A parsed glTF 2.0 document. Problems are added, and what is returned then means nothing.
SceneUse read_gltf(const Place& root, const Container& container, const SceneChoice& choice);

}  // namespace kiln
