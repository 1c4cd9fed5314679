// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>

#include "server/scene/bounds.h"
#include "server/scene/gltf.h"
#include "server/spec/json_text.h"

namespace kiln {

namespace {

constexpr double kUnbounded = std::numeric_limits<double>::infinity();

using Transfer = double (*)(double);
double as_stored(double code) { return code; }

/// Reads one material; names are those of glTF 2.0 and of its KHR_materials_ extensions.
class Reader {
  public:
    Reader(const Place& material, GltfTextures& textures, const std::set<std::string>& animated)
        : material_(material),
          extensions_(material.object("extensions")),
          textures_(textures),
          animated_(animated) {}

    MaterialUse read(bool vertex_colours) {
        use_.name = short_name(material_.text("name"));
        use_.measured = measured_of_gltf(material_);
        if (!use_.measured.empty()) return std::move(use_);
        if (extensions_.object("KHR_materials_unlit")) {
            use_.unlit = true;
            return std::move(use_);
        }
        if (const Place glossy = extensions_.object("KHR_materials_pbrSpecularGlossiness"))
            read_specular_glossiness(glossy);
        else
            read_metallic_roughness(vertex_colours);
        read_layers();
        return std::move(use_);
    }

  private:
    /// A number of the material, or everything it may be where an animation moves it.
    Range factor(const Place& owner, const char* name, double fallback, double hi,
                 const char* what) {
        const double value = owner.number(name, fallback, 0, hi);
        return ends(owner, name, value, hi, what);
    }

    ColourRange colour(const Place& owner, const char* name, double fallback, double hi,
                       const char* what, std::size_t count = 3) {
        const auto value = owner.colour(name, fallback, 0, hi, count);
        ColourRange result;
        for (std::size_t c = 0; c < 3; ++c) result[c] = ends(owner, name, value[c], hi, what);
        return result;
    }

    Range ends(const Place& owner, const char* name, double value, double hi, const char* what) {
        if (!owner || !animated_.contains(join_pointer(owner.pointer(), name)))
            return {value, value, Origin::factor};
        note(what, "an animation moves it");
        // The largest double stands for no bound: times 0 it is 0.
        return {0, std::min(hi, std::numeric_limits<double>::max()), Origin::animation};
    }

    /// factor times a channel of a texture, where there is one.
    Range times(const Range& factor, const TextureLook& texture, std::size_t channel,
                const char* what, Transfer transfer = as_stored) {
        if (!texture.present) return factor;
        if (!texture.texels) {
            // Nothing hangs on the texels of what is 0 in any case.
            if (factor.hi != 0) note(what, texture.why_not);
            return {0, factor.hi, std::max(factor.origin, Origin::texture)};
        }
        return {factor.lo * transfer(texture.texels->lo[channel]),
                factor.hi * transfer(texture.texels->hi[channel]),
                std::max(factor.origin, Origin::texels)};
    }

    ColourRange times(const ColourRange& factor, const TextureLook& texture, const char* what) {
        ColourRange result;
        for (std::size_t c = 0; c < 3; ++c)
            result[c] = times(factor[c], texture, c, what, linear_from_srgb);
        return result;
    }

    void note(const char* what, const std::string& why) {
        const std::string text = std::string(what) + ": " + why + "; every value it could take";
        if (std::find(use_.notes.begin(), use_.notes.end(), text) == use_.notes.end())
            use_.notes.push_back(text);
    }

    void read_metallic_roughness(bool vertex_colours) {
        const Place pbr = material_.object("pbrMetallicRoughness");
        const TextureLook both = textures_.look(pbr, "metallicRoughnessTexture");
        use_.roughness =
            times(factor(pbr, "roughnessFactor", 1, 1, "roughness"), both, 1, "roughness");
        use_.metallic = times(factor(pbr, "metallicFactor", 1, 1, "metallic"), both, 2, "metallic");
        pbr.colour("baseColorFactor", 1, 0, 1, 4);
        read_dielectric();
        const bool metal = use_.metallic.hi > 0, other = use_.metallic.lo < 1;
        if (metal) {
            use_.lobes.add(Lobe::metal);
            use_.metal_f0 = times(colour(pbr, "baseColorFactor", 1, 1, "base colour", 4),
                                  textures_.look(pbr, "baseColorTexture"), "base colour");
            if (vertex_colours)
                for (Range& channel : use_.metal_f0) channel = {0, channel.hi, Origin::texture};
        }
        if (!other) return;
        if (use_.f90.hi > 0) use_.lobes.add(Lobe::dielectric);
        read_under_the_surface();
    }

    /// F0 of KHR_materials_ior and KHR_materials_specular.
    void read_dielectric() {
        use_.ior = 1.5;
        Range normal = normal_reflectance(use_.ior);
        if (const Place ior = extensions_.object("KHR_materials_ior")) {
            const Range given = factor(ior, "ior", 1.5, kUnbounded, "ior");
            use_.ior = ior.number("ior", 1.5, 0, kUnbounded);
            // 0 stands for an infinite index: F0 = 1.
            if (use_.ior > 0 && use_.ior < 1) ior.refuse("ior must be 0 or at least 1");
            normal = given.fixed() ? normal_reflectance(use_.ior) : Range{0, 1, given.origin};
        }
        const Place specular = extensions_.object("KHR_materials_specular");
        use_.f90 = times(factor(specular, "specularFactor", 1, 1, "specular"),
                         textures_.look(specular, "specularTexture"), 3, "specular");
        const ColourRange tint =
            times(colour(specular, "specularColorFactor", 1, kUnbounded, "specular colour"),
                  textures_.look(specular, "specularColorTexture"), "specular colour");
        for (std::size_t c = 0; c < 3; ++c)
            use_.f0[c] = {std::min(normal.lo * tint[c].lo, 1.0) * use_.f90.lo,
                          std::min(normal.hi * tint[c].hi, 1.0) * use_.f90.hi,
                          std::max({normal.origin, tint[c].origin, use_.f90.origin})};
    }

    /// Of a dielectric in air.
    static Range normal_reflectance(double ior) {
        const double ratio = (ior - 1) / (ior + 1);
        return {ratio * ratio, ratio * ratio};
    }

    /// Diffuse, transmission, diffuse transmission: what is left of the light below a dielectric.
    void read_under_the_surface() {
        const Range through = weight("KHR_materials_transmission", "transmissionFactor",
                                     "transmissionTexture", 0, "transmission");
        if (through.hi > 0) use_.lobes.add(Lobe::transmission);
        if (through.lo == 1) return;
        const Range behind =
            weight("KHR_materials_diffuse_transmission", "diffuseTransmissionFactor",
                   "diffuseTransmissionTexture", 3, "diffuse transmission");
        if (behind.hi > 0) use_.lobes.add(Lobe::diffuse_transmission);
        if (behind.lo < 1) use_.lobes.add(Lobe::diffuse);
    }

    Range weight(const char* extension, const char* name, const char* texture, std::size_t channel,
                 const char* what) {
        const Place layer = extensions_.object(extension);
        return times(factor(layer, name, 0, 1, what), textures_.look(layer, texture), channel,
                     what);
    }

    void read_specular_glossiness(const Place& glossy) {
        use_.lobes.add(Lobe::specular_glossiness);
        use_.lobes.add(Lobe::diffuse);
        const TextureLook both = textures_.look(glossy, "specularGlossinessTexture");
        const Range gloss =
            times(factor(glossy, "glossinessFactor", 1, 1, "glossiness"), both, 3, "glossiness");
        use_.roughness = {1 - gloss.hi, 1 - gloss.lo, gloss.origin};
        use_.f0 = times(colour(glossy, "specularFactor", 1, 1, "specular colour"), both,
                        "specular colour");
    }

    void read_layers() {
        if (const Place sheen = extensions_.object("KHR_materials_sheen")) {
            const ColourRange cloth = times(colour(sheen, "sheenColorFactor", 0, 1, "sheen"),
                                            textures_.look(sheen, "sheenColorTexture"), "sheen");
            if (cloth[0].hi > 0 || cloth[1].hi > 0 || cloth[2].hi > 0) {
                use_.lobes.add(Lobe::sheen);
                use_.sheen_roughness =
                    times(factor(sheen, "sheenRoughnessFactor", 0, 1, "sheen roughness"),
                          textures_.look(sheen, "sheenRoughnessTexture"), 3, "sheen roughness");
            }
        }
        const char* coat = "KHR_materials_clearcoat";
        if (weight(coat, "clearcoatFactor", "clearcoatTexture", 0, "clear coat").hi > 0) {
            use_.lobes.add(Lobe::clearcoat);
            use_.clearcoat_roughness =
                weight(coat, "clearcoatRoughnessFactor", "clearcoatRoughnessTexture", 1,
                       "clear coat roughness");
        }
        const char* brushed = "KHR_materials_anisotropy";
        if (weight(brushed, "anisotropyStrength", "anisotropyTexture", 2, "anisotropy").hi > 0)
            use_.lobes.add(Lobe::anisotropy);
        const char* film = "KHR_materials_iridescence";
        if (weight(film, "iridescenceFactor", "iridescenceTexture", 0, "iridescence").hi > 0)
            use_.lobes.add(Lobe::iridescence);
    }

    const Place& material_;
    Place extensions_;
    GltfTextures& textures_;
    const std::set<std::string>& animated_;
    MaterialUse use_;
};

}  // namespace

std::string measured_of_gltf(const Place& material) {
    return material.extras("extras").measurement(kMeasuredProperty);
}

std::set<std::string> animated_numbers(const Place& root) {
    std::set<std::string> pointers;
    const Place animations = root.list("animations", kSceneEntriesMax);
    for (std::size_t i = 0; i < animations.size(); ++i) {
        const Place channels = animations.item(i).list("channels", kSceneEntriesMax);
        for (std::size_t k = 0; k < channels.size(); ++k) {
            const Place pointer = channels.item(k)
                                      .object("target")
                                      .object("extensions")
                                      .object("KHR_animation_pointer");
            if (pointer) pointers.insert(pointer.text("pointer"));
        }
    }
    return pointers;
}

MaterialUse read_gltf_material(const Place& material, GltfTextures& textures,
                               const std::set<std::string>& animated, bool vertex_colours) {
    return Reader(material, textures, animated).read(vertex_colours);
}

}  // namespace kiln
