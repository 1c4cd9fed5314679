// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/spec/spec.h"

namespace kiln {

/// What a material may be made of. Each enumerator's word in JSON is its own name.
enum class Lobe {
    metal,
    dielectric,
    specular_glossiness,
    diffuse,
    sheen,
    clearcoat,
    transmission,
    diffuse_transmission,
    anisotropy,
    iridescence,
};
inline constexpr std::size_t kLobeCount = 10;
std::string_view to_word(Lobe lobe);
std::optional<Lobe> lobe_from(std::string_view word);

class LobeSet {
  public:
    void add(Lobe lobe) { bits_ |= bit(lobe); }
    void add(const LobeSet& other) { bits_ |= other.bits_; }
    bool has(Lobe lobe) const { return (bits_ & bit(lobe)) != 0; }
    bool empty() const { return bits_ == 0; }
    bool operator==(const LobeSet&) const = default;

  private:
    static unsigned bit(Lobe lobe) { return 1U << static_cast<unsigned>(lobe); }
    unsigned bits_ = 0;
};

/// Where a range is known from.
enum class Origin {
    factor,     ///< a number of the material
    texels,     ///< the texels of an image that was there
    texture,    ///< a texture whose image was not there: everything that its factor allows
    animation,  ///< of a factor that an animation moves: everything it may be
};
std::string_view to_word(Origin origin);

/// Values that a number of a material takes, both ends included.
struct Range {
    double lo = 0, hi = 0;
    Origin origin = Origin::factor;
    bool fixed() const { return lo == hi; }
    bool operator==(const Range&) const = default;
};
using ColourRange = std::array<Range, 3>;  ///< linear R G B

/// What one used material asks of a renderer. A number that no lobe of it reads is not looked at.
struct MaterialUse {
    std::optional<std::size_t> index;  ///< in the document; empty: the default material
    std::string name;
    bool unlit = false;
    LobeSet lobes;
    Range roughness{1, 1};  ///< of metal, dielectric, specular_glossiness and transmission
    Range metallic{1, 1};
    double ior = 1.5;
    ColourRange metal_f0{Range{1, 1}, Range{1, 1}, Range{1, 1}};
    /// Of dielectric, or of specular_glossiness.
    ColourRange f0{Range{0.04, 0.04}, Range{0.04, 0.04}, Range{0.04, 0.04}};
    Range f90{1, 1};
    Range sheen_roughness, clearcoat_roughness;
    std::string measured;            ///< id of measured data in place of all of it; "" for none
    std::vector<std::string> notes;  ///< what could not be read, and what is assumed for it
};

struct UnusedMaterial {
    std::size_t index = 0;
    std::string name, why;
    std::string measured;
};

/// A scene, as far as it decides on tables.
struct SceneUse {
    std::string format;                ///< "gltf", "glb" or "materials"
    std::optional<std::size_t> scene;  ///< index of the scene that was taken
    std::size_t scene_count = 0;
    std::vector<MaterialUse> materials;  ///< used, the default material last
    std::vector<UnusedMaterial> unused;
    std::vector<std::string> warnings;
};

/// The document is JSON but no scene, or asks for what it does not hold; all problems at once.
/// HTTP 422.
class InvalidScene : public Error {
  public:
    explicit InvalidScene(std::vector<Problem> found);
    std::vector<Problem> problems;
};

/// Where the document names the measured data of a material that has some.
std::string measured_pointer(const SceneUse& scene, const MaterialUse& material);

struct SceneChoice {
    std::string scene;    ///< index or name of a glTF scene; "" for the default one
    std::string variant;  ///< a name of KHR_materials_variants, "all", or "" for none
};

/// At most kSceneNameBytesMax bytes of a name.
std::string short_name(std::string name);

/// glTF 2.0 (JSON or binary) or the contract's Scene document, at most limits().scene_bytes_max.
/// Nothing outside `bytes` is read. Throws Malformed or InvalidScene.
SceneUse read_scene(std::string_view bytes, const SceneChoice& choice);

}  // namespace kiln
