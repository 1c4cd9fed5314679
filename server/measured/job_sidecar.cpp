// SPDX-License-Identifier: Apache-2.0
#include "server/measured/job_sidecar.h"

#include <nlohmann/json.hpp>

#include "server/measured/reader.h"
#include "server/spec/pixel_words.h"
#include "server/spec/words.h"

namespace kiln::measured {
namespace {

using json = nlohmann::ordered_json;

void add_material(json& entry, const MeasuredMaterial& material, const MaterialNote& note) {
    entry["data"] = kMeasurementPrefix + material.data;
    entry["format"] = note.format;
    entry["title"] = note.title;
    entry["extrapolation"] = {{"p", material.extrapolation.p},
                              {"l", material.extrapolation.l},
                              {"theta_in", to_word(material.extrapolation.theta_in)}};
    for (std::size_t s = 0; s < note.lookup_error.size(); ++s)
        entry["slices"][s]["lookup_error"] = note.lookup_error[s];
    for (const std::string& warning : note.warnings) entry["warnings"].push_back(warning);
}

json fitted_json(const std::vector<FittedMaterial>& fitted) {
    json list = json::array();
    for (const FittedMaterial& one : fitted)
        list.push_back({{"name", one.material.name},
                        {"data", kMeasurementPrefix + one.material.data},
                        {"model", to_string(one.fit.model)},
                        {"alpha", one.fit.width},
                        {"diffuse", one.fit.diffuse},
                        {"f0", one.fit.f0},
                        {"f90", one.fit.f90},
                        {"error", one.fit.error},
                        {"error_worst", one.fit.error_worst},
                        {"left_out", one.left_out}});
    return list;
}

}  // namespace

std::string job_sidecar(const JobSpec& job, const SliceLayout& layout, const SliceTable& made,
                        const std::vector<MaterialNote>& notes,
                        const std::vector<FittedMaterial>& fitted) {
    std::vector<std::string> names;
    for (const MeasuredMaterial& material : job.measured.materials) names.push_back(material.name);
    const json base = json::parse(sidecar_json(layout, made, names));
    json document = {{"kind", to_word(job.kind)},
                     {"readers", kReaderRevision},
                     {"pixel",
                      {{"format", to_word(job.format)},
                       {"type", to_word(job.pixel)},
                       {"layout", pixel_words(job.format, job.pixel)}}}};
    for (const auto& [name, value] : base.items()) document[name] = value;
    for (std::size_t m = 0; m < notes.size(); ++m)
        add_material(document["materials"][m], job.measured.materials[m], notes[m]);
    if (!fitted.empty()) document["fitted"] = fitted_json(fitted);
    return document.dump(-1, ' ', /*ensure_ascii=*/true);
}

}  // namespace kiln::measured
