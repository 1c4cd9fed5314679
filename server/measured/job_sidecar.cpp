// SPDX-License-Identifier: Apache-2.0
#include "server/measured/job_sidecar.h"

#include <nlohmann/json.hpp>

#include "server/measured/reader.h"
#include "server/spec/kinds.h"
#include "server/spec/pixel_words.h"
#include "server/spec/words.h"

namespace kiln::measured {
namespace {

using json = nlohmann::ordered_json;

json fitted_json(const std::vector<FittedMaterial>& fitted) {
    json list = json::array();
    for (const FittedMaterial& one : fitted) {
        json entry = {{"name", one.material.name},
                      {"data", kMeasurementPrefix + one.material.data}};
        entry.update(fit_json(one.fit));
        entry["left_out"] = one.left_out;
        list.push_back(std::move(entry));
    }
    return list;
}

}  // namespace

json sidecar_head(const JobSpec& job) {
    json head = {{"kind", to_word(job.kind)}, {"readers", kReaderRevision}};
    if (!is_view(job.kind))
        head["pixel"] = {{"format", to_word(job.format)},
                         {"type", to_word(job.pixel)},
                         {"layout", pixel_words(job.format, job.pixel, job.kind)}};
    return head;
}

json fit_json(const Fit& fit) {
    return {{"model", to_string(fit.model)},
            {"alpha", fit.width},
            {"diffuse", fit.diffuse},
            {"f0", fit.f0},
            {"f90", fit.f90},
            {"error", fit.error},
            {"error_worst", fit.error_worst}};
}

void add_material(json& entry, const MeasuredMaterial& material, const MaterialNote& note) {
    entry["data"] = kMeasurementPrefix + material.data;
    entry["format"] = note.format;
    entry["title"] = note.title;
    entry["colour"] = note.colour;
    entry["phi_in_deg"] = nullptr;
    if (material.phi_in) entry["phi_in_deg"] = *material.phi_in;
    entry["azimuths"] = {{"measured", note.azimuths.measured}, {"spread", note.azimuths.spread}};
    entry["extrapolation"] = {{"p", note.extrapolation.p},
                              {"l", note.extrapolation.l},
                              {"theta_in", to_word(note.extrapolation.theta_in)}};
    if (!entry.contains("warnings")) entry["warnings"] = json::array();
    for (const std::string& warning : note.warnings) entry["warnings"].push_back(warning);
}

std::string job_sidecar(const JobSpec& job, const SliceLayout& layout, const SliceTable& made,
                        const std::vector<MaterialNote>& notes,
                        const std::vector<FittedMaterial>& fitted) {
    std::vector<std::string> names;
    for (const MeasuredMaterial& material : job.measured.materials) names.push_back(material.name);
    const json base = json::parse(sidecar_json(layout, made, names));
    json document = sidecar_head(job);
    for (const auto& [name, value] : base.items()) document[name] = value;
    for (std::size_t m = 0; m < notes.size(); ++m) {
        json& entry = document["materials"][m];
        add_material(entry, job.measured.materials[m], notes[m]);
        for (std::size_t s = 0; s < notes[m].lookup_error.size(); ++s)
            entry["slices"][s]["lookup_error"] = notes[m].lookup_error[s];
    }
    if (!fitted.empty()) document["fitted"] = fitted_json(fitted);
    return document.dump(-1, ' ', /*ensure_ascii=*/true);
}

}  // namespace kiln::measured
