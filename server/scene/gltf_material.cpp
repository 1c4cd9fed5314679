// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>

#include "server/scene/gltf.h"

namespace kiln {

namespace {

constexpr double kUnbounded = std::numeric_limits<double>::infinity();

using Transfer = double (*)(double);
double as_stored(double code) { return code; }

/// Reads one material; names are those of glTF 2.0 and of its KHR_materials_ extensions.
class Reader {
  public:
    Reader(const Place& material, GltfTextures& textures)
        : material_(material), extensions_(material.object("extensions")), textures_(textures) {}

    MaterialUse read(bool vertex_colours) {
        use_.name = short_name(material_.text("name"));
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
    /// factor times a channel of a texture, where there is one.
    Range times(double factor, const TextureLook& texture, std::size_t channel, const char* what,
                Transfer transfer = as_stored) {
        if (!texture.present) return {factor, factor, Origin::factor};
        if (!texture.texels) {
            // Nothing hangs on the texels of what is 0 in any case.
            if (factor != 0) note(what, texture.why_not);
            return {0, factor, Origin::texture};
        }
        return {factor * transfer(texture.texels->lo[channel]),
                factor * transfer(texture.texels->hi[channel]), Origin::texels};
    }

    ColourRange times(const std::array<double, 3>& factor, const TextureLook& texture,
                      const char* what) {
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
        use_.roughness = times(pbr.number("roughnessFactor", 1, 0, 1), both, 1, "roughness");
        use_.metallic = times(pbr.number("metallicFactor", 1, 0, 1), both, 2, "metallic");
        const auto base = pbr.colour("baseColorFactor", 1, 0, 1, 4);
        read_dielectric();
        const bool metal = use_.metallic.hi > 0, other = use_.metallic.lo < 1;
        if (metal) {
            use_.lobes.add(Lobe::metal);
            use_.metal_f0 = times(base, textures_.look(pbr, "baseColorTexture"), "base colour");
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
        if (const Place ior = extensions_.object("KHR_materials_ior")) {
            use_.ior = ior.number("ior", 1.5, 0, kUnbounded);
            // 0 stands for an infinite index: F0 = 1.
            if (use_.ior > 0 && use_.ior < 1) ior.refuse("ior must be 0 or at least 1");
        }
        const double ratio = (use_.ior - 1) / (use_.ior + 1);
        const double normal = ratio * ratio;
        const Place specular = extensions_.object("KHR_materials_specular");
        use_.f90 = times(specular.number("specularFactor", 1, 0, 1),
                         textures_.look(specular, "specularTexture"), 3, "specular");
        const ColourRange tint =
            times(specular.colour("specularColorFactor", 1, 0, kUnbounded),
                  textures_.look(specular, "specularColorTexture"), "specular colour");
        for (std::size_t c = 0; c < 3; ++c)
            use_.f0[c] = {std::min(normal * tint[c].lo, 1.0) * use_.f90.lo,
                          std::min(normal * tint[c].hi, 1.0) * use_.f90.hi,
                          std::max(tint[c].origin, use_.f90.origin)};
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

    Range weight(const char* extension, const char* factor, const char* texture,
                 std::size_t channel, const char* what) {
        const Place layer = extensions_.object(extension);
        return times(layer.number(factor, 0, 0, 1), textures_.look(layer, texture), channel, what);
    }

    void read_specular_glossiness(const Place& glossy) {
        use_.lobes.add(Lobe::specular_glossiness);
        use_.lobes.add(Lobe::diffuse);
        const TextureLook both = textures_.look(glossy, "specularGlossinessTexture");
        const Range gloss =
            times(glossy.number("glossinessFactor", 1, 0, 1), both, 3, "glossiness");
        use_.roughness = {1 - gloss.hi, 1 - gloss.lo, gloss.origin};
        use_.f0 = times(glossy.colour("specularFactor", 1, 0, 1), both, "specular colour");
    }

    void read_layers() {
        if (const Place sheen = extensions_.object("KHR_materials_sheen")) {
            const ColourRange colour = times(sheen.colour("sheenColorFactor", 0, 0, 1),
                                             textures_.look(sheen, "sheenColorTexture"), "sheen");
            if (colour[0].hi > 0 || colour[1].hi > 0 || colour[2].hi > 0) {
                use_.lobes.add(Lobe::sheen);
                use_.sheen_roughness =
                    times(sheen.number("sheenRoughnessFactor", 0, 0, 1),
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
    MaterialUse use_;
};

}  // namespace

MaterialUse read_gltf_material(const Place& material, GltfTextures& textures, bool vertex_colours) {
    return Reader(material, textures).read(vertex_colours);
}

}  // namespace kiln
