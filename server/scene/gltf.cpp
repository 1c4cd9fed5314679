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

std::string plural(std::size_t count, const std::string& noun) {
    return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

class Gltf {
  public:
    Gltf(const Place& root, const Container& container, const SceneChoice& choice)
        : root_(root),
          choice_(choice),
          scenes_(root.list("scenes", kSceneEntriesMax)),
          nodes_(root.list("nodes", kSceneEntriesMax)),
          meshes_(root.list("meshes", kSceneEntriesMax)),
          materials_(root.list("materials", kSceneEntriesMax)),
          textures_(root, container.binary),
          animated_(animated_numbers(root)) {
        result_.format = container.is_glb ? "glb" : "gltf";
        result_.scene_count = scenes_.size();
        named_.resize(materials_.size());
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
        const Place asset = root_.object("asset");
        const std::string version = asset.text("version");
        if (!asset || (!asset.has("version")))
            root_.refuse("is no glTF 2.0: asset.version is required and missing");
        else if (!version.starts_with("2."))
            asset.refuse("version is " + in_quotes(version) + "; allowed: 2.x");
        const std::string least = asset.text("minVersion");
        if (!least.empty() && least != "2.0")
            asset.refuse("minVersion is " + in_quotes(least) + "; allowed: 2.0");
    }

    /// Names that are not known: all that are required, and used ones that speak of materials.
    void check_extensions() {
        std::set<std::string> unknown;
        const auto look = [&](const char* list, const char* part) {
            for (const std::string& name : root_.texts(list, kSceneEntriesMax)) {
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
        look("extensionsRequired", "");
        look("extensionsUsed", "_materials_");
    }

    void choose_variant() {
        const Place extension = root_.object("extensions").object("KHR_materials_variants");
        const Place variants = extension.list("variants", kSceneEntriesMax);
        variant_count_ = variants.size();
        if (choice_.variant.empty() || choice_.variant == "all") return;
        std::string known;
        for (std::size_t i = 0; i < variants.size(); ++i) {
            const std::string name = variants.item(i).text("name");
            if (name == choice_.variant) variant_ = i;
            if (i < 20) known += (known.empty() ? "" : ", ") + in_quotes(name);
        }
        if (!variant_)
            root_.refuse("has no material variant " + in_quotes(choice_.variant) +
                         "; there are: all" + (known.empty() ? "" : ", " + known));
    }

    /// Index of the scene to take; empty where the document has none.
    std::optional<std::size_t> chosen_scene() {
        if (choice_.scene.empty()) {
            if (scenes_.size() == 0) return std::nullopt;
            return root_.index("scene", scenes_.size(), "scenes").value_or(0);
        }
        for (std::size_t i = 0; i < scenes_.size(); ++i)
            if (choice_.scene == std::to_string(i) || scenes_.item(i).text("name") == choice_.scene)
                return i;
        root_.refuse("has no scene " + in_quotes(choice_.scene) + "; it has " +
                     plural(scenes_.size(), "scene") + ", by index from 0 or by name");
        return std::nullopt;
    }

    std::vector<std::size_t> reached_meshes() {
        result_.scene = chosen_scene();
        std::vector<bool> used(meshes_.size());
        if (!result_.scene && scenes_.size() == 0) {
            result_.warnings.push_back("the document has no scene: all of its meshes are taken");
            used.assign(meshes_.size(), true);
        }
        if (result_.scene) mark_meshes(scenes_.item(*result_.scene), used);
        std::vector<std::size_t> list;
        for (std::size_t i = 0; i < used.size(); ++i)
            if (used[i]) list.push_back(i);
        return list;
    }

    void mark_meshes(const Place& scene, std::vector<bool>& used) {
        std::vector<bool> seen(nodes_.size());
        std::vector<std::size_t> open =
            scene.indices("nodes", nodes_.size(), "nodes", kSceneEntriesMax);
        while (!open.empty()) {
            const std::size_t index = open.back();
            open.pop_back();
            const Place node = nodes_.item(index);
            if (seen[index]) {
                node.refuse("is reached twice: a node has one parent at most, and no loops");
                return;
            }
            seen[index] = true;
            if (const auto mesh = node.index("mesh", meshes_.size(), "meshes")) used[*mesh] = true;
            const auto children =
                node.indices("children", nodes_.size(), "nodes", kSceneEntriesMax);
            open.insert(open.end(), children.begin(), children.end());
        }
    }

    void use_mesh(std::size_t index) {
        const Place mesh = meshes_.item(index);
        const Place primitives = mesh.list("primitives", kSceneEntriesMax);
        for (std::size_t i = 0; i < primitives.size(); ++i) use_primitive(primitives.item(i));
        if (mesh && !mesh.has("primitives")) mesh.refuse("must have primitives");
    }

    void use_primitive(const Place& primitive) {
        if (!primitive) return;
        const bool colours = primitive.object("attributes").has("COLOR_0");
        auto material = primitive.index("material", materials_.size(), "materials");
        const bool wrong = primitive.has("material") && !material;
        const Place mappings = primitive.object("extensions")
                                   .object("KHR_materials_variants")
                                   .list("mappings", kSceneEntriesMax);
        for (std::size_t i = 0; i < mappings.size(); ++i) {
            const Place mapping = mappings.item(i);
            const auto other = mapping.index("material", materials_.size(), "materials");
            const auto variants =
                mapping.indices("variants", variant_count_, "variants", kSceneEntriesMax);
            if (!other) continue;
            named_[*other].by_variant = true;
            if (choice_.variant == "all") name(*other, colours);
            if (variant_ &&
                std::find(variants.begin(), variants.end(), *variant_) != variants.end())
                material = other;
        }
        if (material)
            name(*material, colours);
        else if (!wrong)
            default_used_ = true, default_colours_ |= colours;
    }

    void name(std::size_t material, bool colours) {
        named_[material].used = true;
        named_[material].vertex_colours |= colours;
    }

    void read_materials() {
        std::size_t used_count = 0;
        for (std::size_t i = 0; i < named_.size(); ++i) {
            const Place material = materials_.item(i);
            if (!named_[i].used) {
                if (result_.unused.size() < kSceneMaterialsMax)
                    result_.unused.push_back({i, short_name(material.text("name")),
                                              named_[i].by_variant
                                                  ? "only a material variant names it"
                                                  : "no primitive that the scene reaches names it",
                                              measured_of_gltf(material)});
                continue;
            }
            if (++used_count > kSceneMaterialsMax) {
                material.refuse("is one more than the " + std::to_string(kSceneMaterialsMax) +
                                " used materials that a scene may have");
                return;
            }
            result_.materials.push_back(
                read_gltf_material(material, textures_, animated_, named_[i].vertex_colours));
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

    const Place& root_;
    const SceneChoice& choice_;
    Place scenes_, nodes_, meshes_, materials_;
    GltfTextures textures_;
    std::set<std::string> animated_;
    std::vector<Named> named_;
    std::optional<std::size_t> variant_;
    std::size_t variant_count_ = 0;
    bool default_used_ = false, default_colours_ = false;
    SceneUse result_;
};

}  // namespace

SceneUse read_gltf(const Place& root, const Container& container, const SceneChoice& choice) {
    return Gltf(root, container, choice).read();
}

}  // namespace kiln
