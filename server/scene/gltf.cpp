// SPDX-License-Identifier: Apache-2.0
#include "server/scene/gltf.h"

#include <algorithm>
#include <array>
#include <set>

#include "server/scene/bounds.h"
#include "server/spec/json_text.h"

namespace kiln {

namespace {

/// Extensions that are understood, or that no table hangs on.
constexpr std::array<std::string_view, 33> kExtensions = {
    "EXT_lights_ies",
    "EXT_lights_image_based",
    "EXT_mesh_gpu_instancing",
    "EXT_mesh_manifold",
    "EXT_meshopt_compression",
    "EXT_texture_astc",
    "EXT_texture_avif",
    "EXT_texture_webp",
    "KHR_accessor_float64",
    "KHR_animation_pointer",
    "KHR_draco_mesh_compression",
    "KHR_lights_punctual",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_diffuse_transmission",
    "KHR_materials_dispersion",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_node_visibility",
    "KHR_texture_basisu",
    "KHR_texture_transform",
    "KHR_xmp_json_ld",
    "MSFT_texture_dds",
    "KHR_meshopt_compression",
};

constexpr const char* kVariants = "KHR_materials_variants";

std::string entry_of(const char* list, std::size_t index) {
    return std::string("/") + list + "/" + std::to_string(index);
}

std::string plural(std::size_t count, const std::string& noun) {
    return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

class Gltf {
  public:
    Gltf(const tinygltf::Model& model, std::string_view binary, const SceneChoice& choice,
         ProblemList& problems)
        : model_(model),
          choice_(choice),
          problems_(problems),
          textures_(model, binary, problems),
          animated_(animated_numbers(model)),
          named_(model.materials.size()) {
        result_.scene_count = model.scenes.size();
    }

    SceneUse read() {
        check_version();
        check_extensions();
        choose_variant();
        for (const std::size_t mesh : reached_meshes()) use_mesh(mesh);
        read_materials();
        return std::move(result_);
    }

  private:
    /// How a material is named by the primitives that were reached.
    struct Named {
        bool used = false, by_variant = false, vertex_colours = false;
    };

    void check_version() {
        const auto check = [&](const char* name, const std::string& version, bool known,
                               const char* allowed) {
            if (!known)
                problems_.add(join_pointer("/asset", name),
                              "is " + in_quotes(version) + "; allowed: " + allowed);
        };
        const tinygltf::Asset& asset = model_.asset;
        check("version", asset.version, asset.version.starts_with("2."), "2.x");
        check("minVersion", asset.minVersion, asset.minVersion.empty() || asset.minVersion == "2.0",
              "2.0");
    }

    /// Names that are not known: all that are required, and used ones that speak of materials.
    void check_extensions() {
        std::set<std::string> unknown;
        const auto look = [&](const char* list, const std::vector<std::string>& names,
                              const char* part) {
            for (const std::string& name : names) {
                const bool known =
                    std::find(kExtensions.begin(), kExtensions.end(), name) != kExtensions.end();
                if (known || name.find(part) == std::string::npos ||
                    unknown.size() >= kSceneMaterialsMax || !unknown.insert(name).second)
                    continue;
                result_.warnings.push_back(
                    std::string(list) + " names " + in_quotes(name) +
                    ", which is not known here: materials may need more than this plan has");
            }
        };
        look("extensionsRequired", model_.extensionsRequired, "");
        look("extensionsUsed", model_.extensionsUsed, "_materials_");
        look("extensionsUsed", model_.extensionsUsed, "MSFT_lod");
    }

    void choose_variant() {
        const auto extension = model_.extensions.find(kVariants);
        if (extension != model_.extensions.end() && extension->second.Has("variants"))
            variants_ = &extension->second.Get("variants");
        if (choice_.variant.empty() || choice_.variant == "all") return;
        std::string known;
        for (std::size_t i = 0; i < variant_count(); ++i) {
            const auto& name = variants_->Get(static_cast<int>(i)).Get("name").Get<std::string>();
            if (name == choice_.variant) variant_ = i;
            if (i < 20) known += (known.empty() ? "" : ", ") + in_quotes(name);
        }
        if (!variant_)
            problems_.add("", "has no material variant " + in_quotes(choice_.variant) +
                                  "; there are: all" + (known.empty() ? "" : ", " + known));
    }
    std::size_t variant_count() const { return variants_ == nullptr ? 0 : variants_->ArrayLen(); }

    /// Index of the scene to take; empty where the document has none.
    std::optional<std::size_t> chosen_scene() {
        const auto& scenes = model_.scenes;
        if (choice_.scene.empty()) {
            if (scenes.empty()) return std::nullopt;
            if (model_.defaultScene < 0) return 0;
            return index_among(model_.defaultScene, scenes.size(), "scenes", "/scene", problems_);
        }
        for (std::size_t i = 0; i < scenes.size(); ++i)
            if (choice_.scene == std::to_string(i)) return i;
        for (std::size_t i = 0; i < scenes.size(); ++i)
            if (choice_.scene == scenes[i].name) return i;
        problems_.add("", "has no scene " + in_quotes(choice_.scene) + "; it has " +
                              plural(scenes.size(), "scene") + ", by index from 0 or by name");
        return std::nullopt;
    }

    std::vector<std::size_t> reached_meshes() {
        result_.scene = chosen_scene();
        std::vector<bool> used(model_.meshes.size());
        if (!result_.scene && model_.scenes.empty()) {
            result_.warnings.push_back("the document has no scene: all of its meshes are taken");
            used.assign(used.size(), true);
        }
        if (result_.scene) mark_meshes(*result_.scene, used);
        std::vector<std::size_t> list;
        for (std::size_t i = 0; i < used.size(); ++i)
            if (used[i]) list.push_back(i);
        return list;
    }

    void mark_meshes(std::size_t scene, std::vector<bool>& used) {
        std::vector<bool> seen(model_.nodes.size());
        std::vector<std::size_t> open;
        const auto add = [&](const std::vector<int>& nodes, const std::string& pointer) {
            for (std::size_t i = 0; i < nodes.size(); ++i)
                if (const auto node =
                        index_among(nodes[i], model_.nodes.size(), "nodes",
                                    join_pointer(pointer, std::to_string(i)), problems_))
                    open.push_back(*node);
        };
        add(model_.scenes[scene].nodes, entry_of("scenes", scene) + "/nodes");
        while (!open.empty()) {
            const std::size_t index = open.back();
            open.pop_back();
            const std::string pointer = entry_of("nodes", index);
            if (seen[index]) {
                problems_.add(pointer,
                              "is reached twice: a node has one parent at most, and no loops");
                return;
            }
            seen[index] = true;
            const tinygltf::Node& node = model_.nodes[index];
            if (node.mesh >= 0)
                if (const auto mesh =
                        index_among(node.mesh, used.size(), "meshes", pointer + "/mesh", problems_))
                    used[*mesh] = true;
            add(node.children, pointer + "/children");
        }
    }

    void use_mesh(std::size_t index) {
        const auto& primitives = model_.meshes[index].primitives;
        for (std::size_t i = 0; i < primitives.size(); ++i)
            use_primitive(primitives[i], join_pointer(entry_of("meshes", index) + "/primitives",
                                                      std::to_string(i)));
    }

    void use_primitive(const tinygltf::Primitive& primitive, const std::string& pointer) {
        const bool colours = primitive.attributes.contains("COLOR_0");
        std::optional<std::size_t> material;
        if (primitive.material >= 0) {
            material = material_at(primitive.material, pointer + "/material");
            if (!material) return;
        }
        const auto extension = primitive.extensions.find(kVariants);
        if (extension != primitive.extensions.end())
            if (const auto other = use_variants(extension->second, colours,
                                                pointer + "/extensions/" + kVariants + "/mappings"))
                material = other;
        if (material)
            name(*material, colours);
        else
            default_used_ = true, default_colours_ |= colours;
    }

    /// The material that the chosen variant puts in the place of a primitive's own.
    std::optional<std::size_t> use_variants(const tinygltf::Value& extension, bool colours,
                                            const std::string& pointer) {
        std::optional<std::size_t> chosen;
        if (!extension.Has("mappings")) return chosen;
        const tinygltf::Value& mappings = extension.Get("mappings");
        for (std::size_t i = 0; i < mappings.ArrayLen(); ++i) {
            const tinygltf::Value& mapping = mappings.Get(static_cast<int>(i));
            const std::string place = join_pointer(pointer, std::to_string(i));
            const auto other =
                material_at(mapping.Get("material").GetNumberAsInt(), place + "/material");
            if (!other) continue;
            named_[*other].by_variant = true;
            if (choice_.variant == "all") name(*other, colours);
            const tinygltf::Value& variants = mapping.Get("variants");
            for (std::size_t k = 0; k < variants.ArrayLen(); ++k) {
                const auto variant = index_among(
                    variants.Get(static_cast<int>(k)).GetNumberAsInt(), variant_count(), "variants",
                    join_pointer(place + "/variants", std::to_string(k)), problems_);
                if (variant && variant == variant_) chosen = other;
            }
        }
        return chosen;
    }

    std::optional<std::size_t> material_at(int index, const std::string& pointer) {
        return index_among(index, named_.size(), "materials", pointer, problems_);
    }

    void name(std::size_t material, bool colours) {
        named_[material].used = true;
        named_[material].vertex_colours |= colours;
    }

    void read_materials() {
        std::size_t used_count = 0;
        for (std::size_t i = 0; i < named_.size(); ++i) {
            const GltfMaterial material{model_.materials[i], entry_of("materials", i)};
            if (!named_[i].used) {
                if (result_.unused.size() < kSceneMaterialsMax)
                    result_.unused.push_back({i, short_name(material.material.name),
                                              named_[i].by_variant
                                                  ? "only a material variant names it"
                                                  : "no primitive that the scene reaches names it",
                                              material.measured(problems_)});
                continue;
            }
            if (++used_count > kSceneMaterialsMax) {
                problems_.add(material.pointer, "is one more than the " +
                                                    std::to_string(kSceneMaterialsMax) +
                                                    " used materials that a scene may have");
                return;
            }
            result_.materials.push_back(read_gltf_material(material, textures_, animated_,
                                                           named_[i].vertex_colours, problems_));
            result_.materials.back().index = i;
        }
        if (!default_used_) return;
        // glTF 2.0, 3.7.2.1: a primitive without a material has one of nothing but defaults.
        MaterialUse plain;
        plain.name = "default material";
        plain.lobes.add(Lobe::metal);
        if (default_colours_)
            for (Range& channel : plain.metal_f0) channel = {0, 1, Origin::texture};
        result_.materials.push_back(std::move(plain));
    }

    const tinygltf::Model& model_;
    const SceneChoice& choice_;
    ProblemList& problems_;
    GltfTextures textures_;
    std::set<std::string> animated_;
    std::vector<Named> named_;
    const tinygltf::Value* variants_ = nullptr;
    std::optional<std::size_t> variant_;
    bool default_used_ = false, default_colours_ = false;
    SceneUse result_;
};

}  // namespace

SceneUse read_gltf(const tinygltf::Model& model, std::string_view binary, const SceneChoice& choice,
                   ProblemList& problems) {
    return Gltf(model, binary, choice, problems).read();
}

}  // namespace kiln
