// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <tiny_gltf.h>

#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>

#include "server/scene/scene.h"
#include "server/scene/texels.h"
#include "server/spec/schema.h"

namespace kiln {

/// `index` where it is one of `count`; a problem at `pointer` where it is not, `what` naming what
/// it counts.
std::optional<std::size_t> index_among(int index, std::size_t count, const char* what,
                                       const std::string& pointer, ProblemList& problems);

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
    GltfTextures(const tinygltf::Model& model, std::string_view binary, ProblemList& problems);
    /// The texture of this index, −1 for none, which stands at `pointer`.
    TextureLook look(int texture, const std::string& pointer);

  private:
    ImageLook look_at(std::size_t image);
    ImageLook look_at_view(std::string_view bytes);
    ImageLook look_at_bytes(std::string_view bytes);
    /// Empty with `why` where the bytes are not in the document.
    std::optional<std::string_view> view_bytes(std::size_t view, std::string& why);
    std::optional<std::string_view> buffer_bytes(std::size_t buffer, std::string& why);

    const tinygltf::Model& model_;
    std::string_view binary_;
    ProblemList& problems_;
    std::uint64_t texels_left_, bytes_left_;
    std::map<std::size_t, ImageLook> looks_;
    std::map<std::pair<const char*, std::size_t>, ImageLook> views_;  ///< by their bytes
    /// Of buffers in data: URIs; empty for one that does not decode.
    std::map<std::size_t, std::optional<std::string>> decoded_;
};

/// Custom properties of a glTF asset that Kiln reads.
inline constexpr const char* kMeasuredProperty = "kiln_measured";

/// One material of a document.
struct GltfMaterial {
    const tinygltf::Material& material;
    std::string pointer;

    /// The id of measured data in its extras, "" where there is none.
    std::string measured(ProblemList& problems) const;
};

/// JSON pointers of the numbers that an animation moves (KHR_animation_pointer).
std::set<std::string> animated_numbers(const tinygltf::Model& model);

/// What a glTF material asks for; `vertex_colours`: a primitive of it has COLOR_0.
MaterialUse read_gltf_material(const GltfMaterial& material, GltfTextures& textures,
                               const std::set<std::string>& animated, bool vertex_colours,
                               ProblemList& problems);

/// A glTF 2.0 document; `binary` is the buffer of a binary one. Problems are added, and what is
/// returned then means nothing.
SceneUse read_gltf(const tinygltf::Model& model, std::string_view binary, const SceneChoice& choice,
                   ProblemList& problems);

}  // namespace kiln
