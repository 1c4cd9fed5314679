// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>

#include "server/scene/bounds.h"
#include "server/scene/gltf.h"
#include "server/spec/json_text.h"
#include "server/spec/measurement_names.h"

namespace kiln {

namespace {

// Where glTF has no bound: times 0 it is 0.
constexpr double kUnbounded = std::numeric_limits<double>::max();

using Transfer = double (*)(double);
double as_stored(double code) { return code; }

/// A number or a colour of a material, and where it stands.
struct Factor {
    std::string pointer;
    std::array<double, 3> value;
};

/// An extension of a material; its members have passed the schema, which gave them their defaults.
class Layer {
  public:
    Layer(const tinygltf::Value* members, std::string pointer)
        : members_(members), pointer_(std::move(pointer)) {}
    explicit operator bool() const { return members_ != nullptr; }
    const std::string& pointer() const { return pointer_; }

    double number(const char* name) const { return members_->Get(name).GetNumberAsDouble(); }
    Factor factor(const char* name) const { return {join_pointer(pointer_, name), {number(name)}}; }
    Factor colour(const char* name) const {
        Factor result{join_pointer(pointer_, name), {}};
        for (int c = 0; c < 3; ++c)
            result.value[static_cast<std::size_t>(c)] =
                members_->Get(name).Get(c).GetNumberAsDouble();
        return result;
    }
    TextureLook texture(GltfTextures& textures, const char* name) const {
        if (members_ == nullptr || !members_->Has(name)) return {};
        return textures.look(members_->Get(name).Get("index").GetNumberAsInt(),
                             join_pointer(pointer_, name) + "/index");
    }

  private:
    const tinygltf::Value* members_;
    std::string pointer_;
};

/// Reads one material; names are those of glTF 2.0 and of its KHR_materials_ extensions.
class Reader {
  public:
    Reader(const GltfMaterial& material, GltfTextures& textures,
           const std::set<std::string>& animated, ProblemList& problems)
        : material_(material.material),
          pointer_(material.pointer),
          textures_(textures),
          animated_(animated),
          problems_(problems) {
        use_.name = short_name(material_.name);
        use_.measured = material.measured(problems);
    }

    MaterialUse read(bool vertex_colours) {
        if (!use_.measured.empty()) return std::move(use_);
        if (layer("KHR_materials_unlit")) {
            use_.unlit = true;
            return std::move(use_);
        }
        if (const Layer glossy = layer("KHR_materials_pbrSpecularGlossiness"))
            read_specular_glossiness(glossy);
        else
            read_metallic_roughness(vertex_colours);
        read_layers();
        return std::move(use_);
    }

  private:
    Layer layer(const char* name) const {
        const auto extension = material_.extensions.find(name);
        return {extension == material_.extensions.end() ? nullptr : &extension->second,
                pointer_ + "/extensions/" + name};
    }

    /// A number of the material, or everything it may be where an animation moves it.
    Range range(const Factor& factor, double hi, const char* what) {
        return ends(factor, factor.value[0], hi, what);
    }

    ColourRange colour_range(const Factor& factor, double hi, const char* what) {
        ColourRange result;
        for (std::size_t c = 0; c < 3; ++c) result[c] = ends(factor, factor.value[c], hi, what);
        return result;
    }

    Range ends(const Factor& factor, double value, double hi, const char* what) {
        if (!animated_.contains(factor.pointer)) return {value, value, Origin::factor};
        note(what, "an animation moves it");
        return {0, hi, Origin::animation};
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
        const tinygltf::PbrMetallicRoughness& pbr = material_.pbrMetallicRoughness;
        const std::string place = pointer_ + "/pbrMetallicRoughness/";
        const TextureLook both = textures_.look(pbr.metallicRoughnessTexture.index,
                                                place + "metallicRoughnessTexture/index");
        use_.roughness =
            times(range({place + "roughnessFactor", {pbr.roughnessFactor}}, 1, "roughness"), both,
                  1, "roughness");
        use_.metallic =
            times(range({place + "metallicFactor", {pbr.metallicFactor}}, 1, "metallic"), both, 2,
                  "metallic");
        read_dielectric();
        const bool metal = use_.metallic.hi > 0, other = use_.metallic.lo < 1;
        if (metal) {
            use_.lobes.add(Lobe::metal);
            const std::vector<double>& base = pbr.baseColorFactor;
            use_.metal_f0 = times(
                colour_range({place + "baseColorFactor", {base.at(0), base.at(1), base.at(2)}}, 1,
                             "base colour"),
                textures_.look(pbr.baseColorTexture.index, place + "baseColorTexture/index"),
                "base colour");
            if (vertex_colours)
                for (Range& channel : use_.metal_f0) channel = {0, channel.hi, Origin::texture};
        }
        if (!other) return;
        if (use_.f90.hi > 0) use_.lobes.add(Lobe::dielectric);
        read_under_the_surface();
    }

    /// F0 of KHR_materials_ior and KHR_materials_specular.
    void read_dielectric() {
        Range normal = normal_reflectance(use_.ior);
        if (const Layer index = layer("KHR_materials_ior")) {
            const Range given = range(index.factor("ior"), kUnbounded, "ior");
            use_.ior = index.number("ior");
            // 0 stands for an infinite index: F0 = 1.
            if (use_.ior > 0 && use_.ior < 1)
                problems_.add(index.pointer() + "/ior", "must be 0 or at least 1");
            normal = given.fixed() ? normal_reflectance(use_.ior) : Range{0, 1, given.origin};
        }
        ColourRange tint{Range{1, 1}, Range{1, 1}, Range{1, 1}};
        if (const Layer specular = layer("KHR_materials_specular")) {
            use_.f90 = times(range(specular.factor("specularFactor"), 1, "specular"),
                             specular.texture(textures_, "specularTexture"), 3, "specular");
            tint = times(
                colour_range(specular.colour("specularColorFactor"), kUnbounded, "specular colour"),
                specular.texture(textures_, "specularColorTexture"), "specular colour");
        }
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
        const Layer owner = layer(extension);
        if (!owner) return {0, 0};
        return times(range(owner.factor(name), 1, what), owner.texture(textures_, texture), channel,
                     what);
    }

    void read_specular_glossiness(const Layer& glossy) {
        use_.lobes.add(Lobe::specular_glossiness);
        use_.lobes.add(Lobe::diffuse);
        const TextureLook both = glossy.texture(textures_, "specularGlossinessTexture");
        const Range gloss =
            times(range(glossy.factor("glossinessFactor"), 1, "glossiness"), both, 3, "glossiness");
        use_.roughness = {1 - gloss.hi, 1 - gloss.lo, gloss.origin};
        use_.f0 = times(colour_range(glossy.colour("specularFactor"), 1, "specular colour"), both,
                        "specular colour");
    }

    void read_layers() {
        if (const Layer sheen = layer("KHR_materials_sheen")) {
            const ColourRange cloth =
                times(colour_range(sheen.colour("sheenColorFactor"), 1, "sheen"),
                      sheen.texture(textures_, "sheenColorTexture"), "sheen");
            if (cloth[0].hi > 0 || cloth[1].hi > 0 || cloth[2].hi > 0) {
                use_.lobes.add(Lobe::sheen);
                use_.sheen_roughness =
                    times(range(sheen.factor("sheenRoughnessFactor"), 1, "sheen roughness"),
                          sheen.texture(textures_, "sheenRoughnessTexture"), 3, "sheen roughness");
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

    const tinygltf::Material& material_;
    const std::string& pointer_;
    GltfTextures& textures_;
    const std::set<std::string>& animated_;
    ProblemList& problems_;
    MaterialUse use_;
};

}  // namespace

std::string GltfMaterial::measured(ProblemList& problems) const {
    if (!material.extras.Has(kMeasuredProperty)) return "";
    const auto& id = material.extras.Get(kMeasuredProperty).Get<std::string>();
    if (!measurement_digest(id).empty()) return id;
    problems.add(pointer + "/extras/" + kMeasuredProperty,
                 "is " + in_quotes(id) + "; must be " + std::string(kMeasurementAllowed));
    return "";
}

std::set<std::string> animated_numbers(const tinygltf::Model& model) {
    std::set<std::string> pointers;
    for (const tinygltf::Animation& animation : model.animations)
        for (const tinygltf::AnimationChannel& channel : animation.channels) {
            const auto extension = channel.target_extensions.find("KHR_animation_pointer");
            if (extension != channel.target_extensions.end() && extension->second.Has("pointer"))
                pointers.insert(extension->second.Get("pointer").Get<std::string>());
        }
    return pointers;
}

MaterialUse read_gltf_material(const GltfMaterial& material, GltfTextures& textures,
                               const std::set<std::string>& animated, bool vertex_colours,
                               ProblemList& problems) {
    return Reader(material, textures, animated, problems).read(vertex_colours);
}

}  // namespace kiln
