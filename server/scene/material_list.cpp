// SPDX-License-Identifier: Apache-2.0
#include "server/scene/material_list.h"

#include <nlohmann/json.hpp>

#include "server/spec/contract.h"
#include "server/spec/json_text.h"
#include "server/spec/measurement_names.h"

namespace kiln {

namespace {

using Json = nlohmann::json;

/// One material of a walked document.
class Reader {
  public:
    Reader(const Json& entry, std::string pointer, ProblemList& problems)
        : entry_(entry), pointer_(std::move(pointer)), problems_(problems) {}

    MaterialUse read(std::size_t index) {
        use_.index = index;
        use_.name = entry_.value("name", "");
        use_.measured = entry_.value("measured", "");
        if (entry_.contains("measured") && measurement_digest(use_.measured).empty())
            refuse("measured", "is " + in_quotes(use_.measured) + "; must be " +
                                   std::string(kMeasurementAllowed));
        for (const Json& word : entry_.at("lobes"))
            use_.lobes.add(lobe_from(word.get_ref<const std::string&>()).value());
        use_.unlit = use_.lobes.empty() && !entry_.contains("measured");
        if (!use_.measured.empty() && !use_.lobes.empty())
            refuse("lobes", "must be empty: measured data takes their place");
        read_roughness();
        read_reflectance();
        return std::move(use_);
    }

  private:
    bool has(Lobe lobe) const { return use_.lobes.has(lobe); }
    void refuse(const char* name, const std::string& message) {
        problems_.add(join_pointer(pointer_, name), message);
    }

    void read_roughness() {
        const bool ggx = has(Lobe::metal) || has(Lobe::dielectric) ||
                         has(Lobe::specular_glossiness) || has(Lobe::transmission) ||
                         has(Lobe::diffuse);
        use_.roughness = range("roughness", ggx);
        use_.sheen_roughness = range("sheen_roughness", has(Lobe::sheen));
        use_.clearcoat_roughness = range("clearcoat_roughness", has(Lobe::clearcoat));
        use_.metallic = {has(Lobe::dielectric) || has(Lobe::diffuse) ? 0.0 : 1.0,
                         has(Lobe::metal) ? 1.0 : 0.0, Origin::factor};
        if (use_.metallic.lo > use_.metallic.hi) use_.metallic.lo = 0;
    }

    Range range(const char* name, bool read) {
        const auto given = entry_.find(name);
        if (given == entry_.end()) {
            if (read)
                use_.notes.push_back(std::string(name) + ": not given; every value it could take");
            return {0, read ? 1.0 : 0.0, Origin::texture};
        }
        if (!read) refuse(name, "is not read: no lobe of the material has it");
        if (given->is_number()) return {given->get<double>(), given->get<double>()};
        const Range result{given->at(0).get<double>(), given->at(1).get<double>()};
        if (result.lo > result.hi)
            refuse(name, "must not fall: its first entry has to be at most its second");
        return result;
    }

    ColourRange colour(const char* name, bool read, const ColourRange& fallback) {
        const auto given = entry_.find(name);
        if (given == entry_.end()) return fallback;
        if (!read) refuse(name, "is not read: no lobe of the material has it");
        ColourRange result;
        for (std::size_t c = 0; c < 3; ++c) {
            const double value =
                given->is_array() ? given->at(c).get<double>() : given->get<double>();
            result[c] = {value, value};
        }
        return result;
    }

    void read_reflectance() {
        constexpr Range kAny{0, 1, Origin::texture};
        const bool other = has(Lobe::dielectric) || has(Lobe::specular_glossiness);
        if (entry_.contains("ior")) {
            if (!has(Lobe::dielectric))
                refuse("ior", "is not read without the lobe \"dielectric\"");
            if (entry_.contains("f0")) refuse("ior", "and f0 say the same; give one of them");
            use_.ior = entry_["ior"].get<double>();
        }
        const double ratio = (use_.ior - 1) / (use_.ior + 1);
        const Range normal{ratio * ratio, ratio * ratio};
        const ColourRange any{kAny, kAny, kAny};
        use_.metal_f0 = colour("metal_f0", has(Lobe::metal), any);
        use_.f0 =
            colour("f0", other,
                   has(Lobe::specular_glossiness) ? any : ColourRange{normal, normal, normal});
        if (entry_.contains("f90")) {
            if (!other) refuse("f90", "is not read: no lobe of the material has it");
            use_.f90 = {entry_["f90"].get<double>(), entry_["f90"].get<double>()};
        }
    }

    const Json& entry_;
    std::string pointer_;
    ProblemList& problems_;
    MaterialUse use_;
};

}  // namespace

SceneUse read_material_list(const Json& document, ProblemList& problems) {
    SceneUse scene;
    scene.format = "materials";
    const Json walked =
        walk_schema(contract(), contract()["components"]["schemas"]["Scene"], document, problems);
    if (!problems.empty()) return scene;
    const Json& materials = walked["materials"];
    for (std::size_t i = 0; i < materials.size(); ++i) {
        const Json& entry = materials[i];
        MaterialUse use =
            Reader(entry, join_pointer("/materials", std::to_string(i)), problems).read(i);
        if (entry["used"].get<bool>())
            scene.materials.push_back(std::move(use));
        else
            scene.unused.push_back(
                {i, use.name, "the list says that nothing uses it", use.measured});
    }
    return scene;
}

}  // namespace kiln
