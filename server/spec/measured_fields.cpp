// SPDX-License-Identifier: Apache-2.0
#include "server/spec/measured_fields.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "server/base/sha256.h"
#include "server/spec/contract.h"
#include "server/spec/json_text.h"
#include "server/spec/kinds.h"
#include "server/spec/limits.h"
#include "server/spec/measurement_names.h"
#include "server/spec/slice_grid.h"
#include "server/spec/words.h"

namespace kiln {
namespace {

using Json = nlohmann::json;

constexpr std::size_t kNameDigits = 12;
/// Degrees: of a lobe's light unless a job says otherwise, and the most of lobes and samplers.
constexpr double kLobeThetaIn = 30, kLobeThetaInMax = 89;

/// A material as a document has it: where, and what it says.
struct Entry {
    std::string pointer;  ///< of the text that names the measurement
    std::string place;    ///< of the object that holds it, "" where there is none of its own
    const Json* name = nullptr;
    const Json* extrapolation = nullptr;
    const Json* phi_in = nullptr;
    const Json* data = nullptr;
};

std::vector<Entry> entries_of_list(const Json& list, const std::string& pointer) {
    std::vector<Entry> entries;
    for (std::size_t i = 0; i < list.size(); ++i) {
        const std::string place = join_pointer(pointer, std::to_string(i));
        const Json& item = list[i];
        Entry entry{.pointer = place, .place = "", .data = &item};
        if (item.is_object()) {
            entry.place = place;
            entry.pointer = place + "/data";
            entry.data = item.contains("data") ? &item["data"] : nullptr;
            if (item.contains("name")) entry.name = &item["name"];
            if (item.contains("extrapolation")) entry.extrapolation = &item["extrapolation"];
            if (item.contains("phi_in")) entry.phi_in = &item["phi_in"];
        }
        if (entry.data != nullptr && entry.data->is_string()) entries.push_back(entry);
    }
    return entries;
}

/// Of all three forms of `measured`.
std::vector<Entry> entries_of(const Json& measured) {
    if (measured.is_array()) return entries_of_list(measured, "/measured");
    if (!measured.is_object() || !measured.contains("data")) return {};
    const Json& data = measured["data"];
    if (data.is_array()) return entries_of_list(data, "/measured/data");
    if (!data.is_string()) return {};
    Entry entry{.pointer = "/measured/data", .place = "/measured", .data = &data};
    if (measured.contains("name")) entry.name = &measured["name"];
    return {entry};
}

Extrapolation extrapolation_of(const Json& json, Extrapolation result) {
    // Adding 0 turns −0 into 0, so that both are the same job.
    if (json.contains("p")) result.p = json["p"].get<double>() + 0.0;
    if (json.contains("l")) result.l = json["l"].get<double>() + 0.0;
    if (json.contains("theta_in"))
        result.theta_in =
            from_word<ThetaInBeyond>(json["theta_in"].get_ref<const std::string&>()).value();
    return result;
}

class MeasuredReader {
  public:
    /// `given` is what the document says, `measured` the same with defaults.
    MeasuredReader(const Json& given, const Json& measured, ProblemList& problems, JobSpec& job)
        : given_(given), measured_(measured), problems_(problems), job_(job) {}

    void read() {
        const bool list = measured_.is_array();
        Json whole = measured_;
        if (list) {  // the fields that it has no place for stand at their defaults
            ProblemList none(1);
            const Json& schema = contract().at("/components/schemas/Measured"_json_pointer);
            whole = walk_schema(contract(), schema, {{"data", measured_}}, none);
        }
        const std::vector<Entry> entries = entries_of(measured_);
        const Extrapolation usual = extrapolation_of(whole["extrapolation"], {});
        for (const Entry& entry : entries) read_material(entry, usual, whole["phi_in"]);
        check_fields();
        if (is_read_of_measured(job_.kind, "theta_in")) read_angles(whole["theta_in"]);
        job_.measured.gutter = whole["gutter"].get<std::int64_t>();
        job_.measured.conserve = whole["conserve"].get<bool>();
        if (!whole["fit_error_max"].is_null())
            job_.measured.fit_error_max = whole["fit_error_max"].get<double>();
        check_count(list || measured_["data"].is_array());
    }

  private:
    void read_material(const Entry& entry, const Extrapolation& usual, const Json& usual_phi_in) {
        const auto& text = entry.data->get_ref<const std::string&>();
        const std::string digest = measurement_digest(text);
        if (digest.empty()) {
            problems_.add(entry.pointer,
                          "is " + in_quotes(text) + "; must be " + kMeasurementAllowed);
            return;
        }
        MeasuredMaterial material{digest, digest.substr(0, kNameDigits), usual};
        if (entry.name != nullptr) material.name = entry.name->get<std::string>();
        if (entry.extrapolation != nullptr)
            material.extrapolation = extrapolation_of(*entry.extrapolation, usual);
        const Json& phi_in = entry.phi_in != nullptr ? *entry.phi_in : usual_phi_in;
        if (!phi_in.is_null()) {
            material.phi_in = std::fmod(phi_in.get<double>(), 360.0) + 0.0;  // 360 is 0
            if (measured_.is_object() && measured_["conserve"].get<bool>())
                problems_.add(
                    entry.phi_in != nullptr ? entry.place + "/phi_in" : "/measured/phi_in",
                    "does not go with conserve: light and view change places under other "
                    "azimuths too. Leave one of them out");
        }
        job_.measured.materials.push_back(std::move(material));
    }

    void check_fields() {
        if (!given_.is_object()) return;
        for (const char* field : {"theta_in", "gutter", "fit_error_max"})
            if (given_.contains(field) && !is_read_of_measured(job_.kind, field))
                problems_.add(
                    std::string("/measured/") + field,
                    "is not read by kind " + in_quotes(to_word(job_.kind)) + "; leave it out");
    }

    void read_angles(const Json& list) {
        std::vector<double>& angles = job_.measured.theta_in;
        const bool lobe = job_.kind == Kind::lobe_view;
        if (lobe && !(given_.is_object() && given_.contains("theta_in")))
            angles = {kLobeThetaIn};
        else
            for (const Json& angle : list) angles.push_back(angle.get<double>() + 0.0);
        if (lobe && angles.size() > 1)
            problems_.add("/measured/theta_in", "has " + std::to_string(angles.size()) +
                                                    " angles; a lobe is drawn under one");
        // At 90 degrees half of the cells about the mirror direction have no area.
        for (std::size_t i = 0; i < angles.size(); ++i)
            if (!is_sliced(job_.kind) && angles[i] > kLobeThetaInMax)
                problems_.add(
                    "/measured/theta_in/" + std::to_string(i),
                    "is above 89, the last angle of kind " + in_quotes(to_word(job_.kind)));
        for (std::size_t i = 1; i < angles.size(); ++i)
            if (!(angles[i] > angles[i - 1]))
                problems_.add("/measured/theta_in/" + std::to_string(i),
                              "must be above the angle before it: slices lie in rising theta_in");
    }

    void check_count(bool list) {
        const std::size_t count = list ? entries_of(measured_).size() : 1;
        const char* place = measured_.is_array() ? "/measured" : "/measured/data";
        if (job_.kind == Kind::slices && count != 1)
            problems_.add(place, "has " + std::to_string(count) +
                                     " materials; slices are of one, more are an atlas");
        if (job_.kind == Kind::sampling && count != 1)
            problems_.add(
                place, "has " + std::to_string(count) + " materials; a sampling table is of one");
        if (list && measured_.is_object() && measured_.contains("name"))
            problems_.add("/measured/name",
                          "goes with one measurement; in a list each material "
                          "has its own: {\"data\": …, \"name\": …}");
    }

    const Json& given_;
    const Json& measured_;
    ProblemList& problems_;
    JobSpec& job_;
};

/// What `resolution` counts in a measured kind.
struct Sides {
    std::vector<std::int64_t> usual;
    const char* entries;  ///< end of "has N entries; "
    std::int64_t least, most;
    const char* what;
};
Sides sides_of(Kind kind) {
    const Limits& most = limits();
    const char* picture = "a picture has two, [x, y] of one material";
    switch (kind) {
        case Kind::lobe_view:
            return {{640, 480},
                    picture,
                    most.view_side_min,
                    most.view_side_max,
                    "pixels of one material"};
        case Kind::sphere_view:
            return {{512, 512},
                    picture,
                    most.view_side_min,
                    most.view_side_max,
                    "pixels of one material"};
        case Kind::companion:
            return {{64}, "a companion has one, [NoV]", 2, most.resolution_max, "texels of NoV"};
        case Kind::sampling:
            return {{96, 64},
                    "a sampling table has two, [phi_d, rings] of one theta_in",
                    4,
                    most.sampling_side_max,
                    "cells"};
        default:  // Cezner 2024: a degree a step, both ends included
            return {{361, 181},
                    "a slice has two, [phi_d, theta_d]",
                    2,
                    most.resolution_max,
                    "texels, one at each end of an angle"};
    }
}

/// Texels of a slice, and of the image that they make.
void read_resolution(const Json& given, const Json& document, ProblemList& problems, JobSpec& job) {
    const Sides sides = sides_of(job.kind);
    job.resolution = sides.usual;
    if (given.contains("resolution") && problems.sound("/resolution"))
        job.resolution = document["resolution"].get<std::vector<std::int64_t>>();
    if (!problems.sound("/resolution")) return;
    if (job.resolution.size() != sides.usual.size())
        return problems.add("/resolution", "has " + std::to_string(job.resolution.size()) +
                                               " entries; " + sides.entries);
    for (std::size_t i = 0; i < job.resolution.size(); ++i)
        if (job.resolution[i] < sides.least || job.resolution[i] > sides.most)
            problems.add("/resolution/" + std::to_string(i),
                         "is " + std::to_string(job.resolution[i]) +
                             "; allowed: " + std::to_string(sides.least) + "…" +
                             std::to_string(sides.most) + " (" + sides.what + ")");
    if (!problems.sound("/resolution") || !problems.sound("/measured")) return;
    if (const auto why = too_large(slice_grid(job)))
        problems.add("/resolution", "the image " + *why);
}

}  // namespace

void read_measured(const Json& given, const Json& document, ProblemList& problems, JobSpec& job) {
    if (given.contains("measured") && problems.sound("/measured"))
        MeasuredReader(given["measured"], document["measured"], problems, job).read();
    if (is_view(job.kind)) {
        job.format = ImageFormat::png;
        job.pixel = PixelType::uint8;
    }
    read_resolution(given, document, problems, job);
}

Json measured_json(const JobSpec& job) {
    const MeasuredSpec& measured = job.measured;
    Json materials = Json::array();
    for (const MeasuredMaterial& material : measured.materials) {
        materials.push_back({{"data", kMeasurementPrefix + material.data},
                             {"name", material.name},
                             {"extrapolation",
                              {{"p", material.extrapolation.p},
                               {"l", material.extrapolation.l},
                               {"theta_in", to_word(material.extrapolation.theta_in)}}}});
        materials.back()["phi_in"] = nullptr;
        if (material.phi_in) materials.back()["phi_in"] = *material.phi_in;
    }
    Json json = {{"data", materials},
                 {"theta_in", measured.theta_in},
                 {"gutter", measured.gutter},
                 {"conserve", measured.conserve}};
    json["fit_error_max"] = nullptr;
    if (measured.fit_error_max) json["fit_error_max"] = *measured.fit_error_max;
    const Json whole = json;
    for (const auto& [field, value] : whole.items())
        if (!is_read_of_measured(job.kind, field)) json.erase(field);
    return json;
}

std::string measurement_digest(std::string_view id) {
    const std::string_view prefix = kMeasurementPrefix;
    if (!id.starts_with(prefix) || !is_sha256_hex(id.substr(prefix.size()))) return "";
    return std::string(id.substr(prefix.size()));
}

std::vector<std::string> measurement_pointers(std::string_view job_text) {
    std::vector<std::string> pointers;
    const Json document = parse_json(job_text, {limits().job_bytes_max, limits().depth_max});
    if (document.is_object() && document.contains("measured"))
        for (const Entry& entry : entries_of(document["measured"]))
            pointers.push_back(entry.pointer);
    return pointers;
}

std::string with_measurements(std::string_view job_text,
                              const std::function<std::string(const std::string&)>& resolve) {
    Json document;
    try {
        document = parse_json(job_text, {limits().job_bytes_max, limits().depth_max});
    } catch (const Malformed&) {  // parse_job says what is wrong
        return std::string(job_text);
    }
    if (!document.is_object() || !document.contains("measured")) return std::string(job_text);
    const Json before = document["measured"];
    for (const Entry& entry : entries_of(before))
        document[Json::json_pointer(entry.pointer)] = resolve(entry.data->get<std::string>());
    return document.dump();
}

void named_measurements(std::string_view canonical_job, std::set<std::string>& digests) {
    constexpr std::size_t kDigits = 64;
    const std::string_view prefix = kMeasurementPrefix;
    for (std::size_t at = canonical_job.find(prefix); at != canonical_job.npos;
         at = canonical_job.find(prefix, at + 1)) {
        const std::string_view digest = canonical_job.substr(at + prefix.size(), kDigits);
        if (is_sha256_hex(digest)) digests.emplace(digest);
    }
}

}  // namespace kiln
