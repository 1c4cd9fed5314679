// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "server/spec/channels.h"
#include "server/spec/contract.h"
#include "server/spec/json_text.h"
#include "server/spec/kinds.h"
#include "server/spec/layouts.h"
#include "server/spec/limits.h"
#include "server/spec/measured_fields.h"
#include "server/spec/models.h"
#include "server/spec/phrases.h"
#include "server/spec/schema.h"
#include "server/spec/spec.h"
#include "server/spec/words.h"

namespace kiln {
namespace {

using Json = nlohmann::json;

/// Turns a walked document into a JobSpec field by field, and holds the rules that relate fields. A
/// rule is applied when all that it reads is sound, so that one answer names every problem.
class Reader {
  public:
    /// `document` has the defaults inserted that `given` leaves out.
    Reader(const Json& given, const Json& document, ProblemList& problems)
        : given_(given), document_(document), problems_(problems) {}

    JobSpec read() {
        if (!document_.is_object()) return {};
        read_word(job_.kind, "/kind");
        if (sound("/kind")) check_fields();
        if (sound("/layout") && at("/layout").is_string())
            job_.layout = at("/layout").get<std::string>();
        read_fields();
        if (is_read(job_.kind, "layout")) read_layout();
        if (job_.integrator == Integrator::quadrature && sound("/quantities", "/layout"))
            check_quadrature();
        if (is_read(job_.kind, "measured")) read_measured(given_, document_, problems_, job_);
        if (is_read(job_.kind, "output")) read_output();
        check_work();
        return std::move(job_);
    }

  private:
    template <class... Pointers>
    bool sound(Pointers... pointers) const {
        return (problems_.sound(pointers) && ...);
    }

    const Json& at(const char* pointer) const { return document_.at(Json::json_pointer(pointer)); }

    template <JobEnum E>
    static E word(const Json& value) {
        return from_word<E>(value.get_ref<const std::string&>()).value();
    }
    template <JobEnum E>
    void read_word(E& field, const char* pointer) {
        if (sound(pointer)) field = word<E>(at(pointer));
    }

    /// Every kind reads some of the fields.
    void check_fields() {
        for (const char* field : {"quantities", "measured"})
            if (is_read(job_.kind, field) && !given_.contains(field))
                problems_.add(std::string("/") + field, "is required and missing");
        std::string read;
        for (const auto& [field, value] : document_.items())
            if (is_read(job_.kind, field)) read += (read.empty() ? "" : ", ") + field;
        for (const auto& [field, value] : given_.items())
            if (document_.contains(field) && !is_read(job_.kind, field))
                problems_.add("/" + field, "is not read by kind " + in_quotes(to_word(job_.kind)) +
                                               "; leave it out. It reads: " + read);
    }

    void read_number(std::optional<double>& field, const char* pointer) {
        if (sound(pointer) && at(pointer).is_number()) field = at(pointer).get<double>();
    }

    void read_fields() {
        if (is_measured(job_.kind)) return read_word(job_.device, "/device");
        if (sound("/quantities") && document_.contains("quantities")) {
            for (const Json& entry : at("/quantities"))
                job_.quantities.push_back(word<Quantity>(entry));
        }
        const LayoutPreset* preset = sound("/layout") ? layout_preset(job_.layout) : nullptr;
        if (preset && !preset->resolution.empty() && !given_.contains("resolution"))
            job_.resolution = size_of(*preset);
        else if (sound("/resolution"))
            job_.resolution = at("/resolution").get<std::vector<std::int64_t>>();
        if (sound("/sample_count")) job_.sample_count = at("/sample_count").get<std::int64_t>();
        read_number(job_.target_error, "/target_error");
        read_number(job_.time_budget_s, "/time_budget_s");
        if (sound("/seed")) job_.seed = at("/seed").get<std::uint64_t>();
        read_word(job_.integrator, "/integrator");
        read_word(job_.sampler, "/sampler");
        prepare_study(job_);
        read_models(document_, problems_, job_);
        read_word(job_.precision, "/precision");
        read_word(job_.device, "/device");
    }

    /// Of the program's table, that along roughness where nothing depends on NoV.
    std::vector<std::int64_t> size_of(const LayoutPreset& preset) const {
        const bool single = preset.single_axis && !job_.quantities.empty() &&
                            std::ranges::none_of(job_.quantities, depends_on_NoV);
        return single ? std::vector{preset.resolution[0]} : preset.resolution;
    }

    static Axis axis(const Json& entry) {
        const Json& range = entry.at("range");
        // Adding 0 turns −0 into 0, so that both are the same job.
        if (entry.contains("values")) {
            Axis listed{.parameter = word<Parameter>(entry.at("parameter"))};
            for (const Json& value : entry.at("values"))
                listed.values.push_back(value.get<double>() + 0.0);
            const auto [least, most] =
                std::minmax_element(listed.values.begin(), listed.values.end());
            listed.lo = *least;
            listed.hi = *most;
            return listed;
        }
        return {.parameter = word<Parameter>(entry.at("parameter")),
                .mapping = word<Mapping>(entry.at("mapping")),
                .grid = word<Grid>(entry.at("grid")),
                .flip = entry.at("flip").get<bool>(),
                .lo = range.at(0).get<double>() + 0.0,
                .hi = range.at(1).get<double>() + 0.0};
    }

    /// The axes of job_.layout, a preset.
    void read_preset() {
        const LayoutPreset& preset = *layout_preset(job_.layout);
        job_.axes = preset.axes;
        if (job_.resolution.size() == 1) {
            if (preset.single_axis)
                job_.axes = {*preset.single_axis};
            else
                problems_.add("/resolution", "has one entry; layout " + in_quotes(preset.name) +
                                                 " is a table of two, [x, y]");
        }
        if (job_.resolution.size() == 3)
            problems_.add("/resolution",
                          "has three entries; a third needs a layout object whose z says what it "
                          "carries (f0 or ior)");
        check_needs("/resolution");
    }

    bool has_kiln_axes() const {
        const LayoutPreset& kiln = *layout_preset(JobSpec{}.layout);
        return job_.axes == kiln.axes || job_.axes == std::vector{*kiln.single_axis};
    }

    /// Which axes a layout object has to have; that x is one of them the schema says.
    void check_presence(const Json& layout) {
        const char* counts[] = {"no entry", "one entry", "two entries", "three entries"};
        const std::size_t axis_count = job_.resolution.size();
        for (std::size_t i = 1; i < 3; ++i) {
            const std::string name(1, "xyz"[i]);
            if (layout.contains(name) == (i < axis_count)) continue;
            const char* what = i < axis_count ? "is required and missing" : "must be left out";
            problems_.add("/layout/" + name,
                          std::string(what) + ": resolution has " + counts[axis_count]);
        }
    }

    void read_layout() {
        if (!sound("/resolution")) return;
        const bool read = sound("/layout");
        const Json& layout = at("/layout");
        if (layout.is_object()) check_presence(layout);
        if (!read) return;
        if (layout.is_string()) return read_preset();
        const std::size_t axis_count = job_.resolution.size();
        for (const char* name : {"x", "y", "z"})
            if (layout.contains(name)) job_.axes.push_back(axis(layout[name]));
        check_axes();
        if (job_.axes.size() == 3 && axis_count == 3) check_depth_axis();
        check_needs("/layout");
        job_.layout = has_kiln_axes() ? JobSpec{}.layout : "custom";
    }

    void check_axes() {
        for (std::size_t i = 0; i < job_.axes.size(); ++i) {
            const Axis& axis = job_.axes[i];
            const std::string place = std::string("/layout/") + "xyz"[i];
            const bool is_ior = axis.parameter == Parameter::ior;
            if (!axis.values.empty())
                check_values(axis, place, i);
            else if (!(axis.lo < axis.hi))
                problems_.add(place + "/range",
                              "must rise: its first entry has to be less than its second");
            if (!is_ior && axis.hi > 1)
                problems_.add(
                    place + end_of(axis, axis.hi),
                    "is above 1; allowed: 0…1 for " + std::string(to_word(axis.parameter)));
            if (i == 2 && is_ior && axis.lo < 0.0001)
                problems_.add(place + end_of(axis, axis.lo), "is below 0.0001, the least ior");
            if (i < 2 && (is_ior || axis.parameter == Parameter::f0))
                problems_.add(place + "/parameter",
                              in_quotes(to_word(axis.parameter)) + " lies along z alone");
        }
        if (job_.axes.size() < 2 || !sound("/layout")) return;
        const auto is_NoV = [](const Axis& a) { return a.parameter == Parameter::NoV; };
        if (is_NoV(job_.axes[0]) != is_NoV(job_.axes[1])) return;
        const bool same = job_.axes[0].parameter == job_.axes[1].parameter;
        problems_.add("/layout/y/parameter",
                      same ? "is the parameter of x too; the axes must carry different ones"
                           : "roughness and alpha are one degree of freedom (alpha = roughness²); "
                             "only one of them can be an axis");
    }

    /// Where a document says `value`, the least or the most of an axis.
    static std::string end_of(const Axis& axis, double value) {
        if (axis.values.empty()) return value == axis.lo ? "/range/0" : "/range/1";
        const auto found = std::find(axis.values.begin(), axis.values.end(), value);
        return "/values/" + std::to_string(found - axis.values.begin());
    }

    void check_values(const Axis& axis, const std::string& place, std::size_t index) {
        const Json::json_pointer given(place);
        for (const char* field : {"mapping", "grid", "flip", "range"})
            if (given_.at(given).contains(field))
                problems_.add(place + "/" + field,
                              "says again where slices lie, which values do; leave it out");
        if (index < 2)
            return problems_.add(place + "/values",
                                 "is a list of slices, of z alone; a shader "
                                 "needs mapping and range of this axis");
        const auto count = job_.resolution.size() == 3 ? job_.resolution[2] : 0;
        const auto listed = static_cast<std::int64_t>(axis.values.size());
        if (count > 0 && listed != count)
            problems_.add(place + "/values", "has " + std::to_string(listed) + " entries for " +
                                                 std::to_string(count) + " slices of resolution");
    }

    /// What quadrature has a rule for: kernels/quadrature.h.
    void check_quadrature() {
        std::set<std::string> reasons;
        for (const Quantity quantity : job_.quantities)
            if (const auto lack = quadrature_lacks(job_, quantity)) reasons.insert(*lack);
        for (const std::string& reason : reasons)
            problems_.add("/integrator", "\"quadrature\" has no rule for " + reason +
                                             "; allowed here: monte_carlo");
    }

    /// z carries a number of the Fresnel model.
    void check_depth_axis() {
        const Parameter parameter = job_.axes[2].parameter;
        const Fresnel model = job_.fresnel.model;
        if (parameter != Parameter::f0 && parameter != Parameter::ior) {
            problems_.add("/layout/z/parameter",
                          in_quotes(to_word(parameter)) + " cannot lie along z; allowed: f0, ior");
            return;
        }
        const bool read = parameter == Parameter::ior
                              ? model == Fresnel::dielectric
                              : model == Fresnel::schlick || model == Fresnel::f82_tint;
        if (sound("/fresnel/model") && !read)
            problems_.add("/layout/z/parameter", in_quotes(to_word(parameter)) +
                                                     " is not read by Fresnel model " +
                                                     in_quotes(to_word(model)));
        const char* given = parameter == Parameter::ior ? "/fresnel/ior" : "/fresnel/f0";
        if (document_.contains(Json::json_pointer(given)))
            problems_.add(given, "lies along the z axis already; leave it out");
    }

    bool has_axis(Parameter parameter) const {
        return std::any_of(job_.axes.begin(), job_.axes.end(),
                           [&](const Axis& a) { return a.parameter == parameter; });
    }

    /// Every parameter that a quantity depends on has to be an axis.
    void check_needs(const char* pointer) {
        if (!sound(pointer) || !sound("/layout")) return;
        if (!has_axis(Parameter::roughness) && !has_axis(Parameter::alpha))
            problems_.add(pointer,
                          "no axis carries roughness (or alpha), on which every quantity depends");
        if (has_axis(Parameter::NoV) || !sound("/quantities")) return;
        std::string needing;
        for (const Quantity quantity : job_.quantities) {
            if (!depends_on_NoV(quantity)) continue;
            needing += (needing.empty() ? "" : ", ") + in_quotes(to_word(quantity));
        }
        if (needing.empty()) return;
        problems_.add(pointer, job_.resolution.size() == 1
                                   ? "one axis is too few: " + needing +
                                         " need NoV and roughness; allowed: two entries, [x, y]"
                                   : "no axis carries NoV, on which depend " + needing);
    }

    void read_output() {
        read_word(job_.format, "/output/format");
        if (!sound("/output/format")) return;
        const Json& allowed = contract().at(Json::json_pointer(
            "/components/schemas/Output/x-kiln-pixels/" + std::string(to_word(job_.format))));
        const Json& output = at("/output");
        if (!output.contains("pixel")) {
            const bool sums = job_.kind == Kind::sampling;
            job_.pixel = sums ? PixelType::float32 : word<PixelType>(allowed.at(0));
        } else if (sound("/output/pixel")) {
            job_.pixel = word<PixelType>(output["pixel"]);
            if (std::find(allowed.begin(), allowed.end(), output["pixel"]) == allowed.end())
                problems_.add("/output/pixel", in_quotes(to_word(job_.pixel)) +
                                                   " is no pixel type of " +
                                                   std::string(to_word(job_.format)) +
                                                   "; allowed: " + list_of(allowed));
        }
        if (job_.kind == Kind::sampling && job_.format != ImageFormat::exr)
            problems_.add("/output/format",
                          "is png; a sampling table is running sums, which need exr");
        else if (job_.kind == Kind::sampling && job_.pixel != PixelType::float32)
            problems_.add("/output/pixel",
                          "is " + in_quotes(to_word(job_.pixel)) +
                              "; a sampling table is running sums, which need \"float\"");
        if (sound("/output/pixel") && job_.pixel == PixelType::rgb9e5 && !is_sliced(job_.kind))
            problems_.add("/output/pixel",
                          "\"rgb9e5\" holds the three colours of measured reflectance: of kinds "
                          "slices and atlas alone");
        const auto channels_max = static_cast<std::size_t>(limits().png_channels_max);
        const std::size_t channels = channels_of(job_).size();
        if (job_.format == ImageFormat::png && channels > channels_max)
            problems_.add("/quantities",
                          "makes " + std::to_string(channels) + " channels; a PNG holds at most " +
                              std::to_string(channels_max) + " channels, only exr holds more");
    }

    /// An upper bound on a job that stops by itself, where none is given.
    void choose_sample_count(std::int64_t texels) {
        if (!(job_.target_error || job_.time_budget_s) || given_.contains("sample_count")) return;
        job_.sample_count = limits().sample_count_max;
        while (job_.sample_count > 1 && job_.sample_count > limits().work_samples_max / texels)
            job_.sample_count /= 2;
    }

    void check_work() {
        if (is_measured(job_.kind) ||
            !sound("/resolution", "/sample_count", "/target_error", "/time_budget_s"))
            return;
        std::int64_t texels = 1;
        for (const std::int64_t extent : job_.resolution) texels *= extent;
        choose_sample_count(texels);
        const std::int64_t work = job_.sample_count * texels;  // at most 2^20 · 2^36: no overflow
        if (work <= limits().work_samples_max) return;
        problems_.add("/sample_count",
                      "the job takes " + std::to_string(work) +
                          " samples (texels times sample_count); allowed: at most " +
                          std::to_string(limits().work_samples_max));
    }

    const Json& given_;
    const Json& document_;
    ProblemList& problems_;
    JobSpec job_;
};

/// One line; the list itself is in InvalidJob::problems.
std::string summary(const std::vector<Problem>& problems) {
    if (problems.empty()) return "the job is not valid";
    const Problem& first = problems.front();
    const std::string place = first.pointer.empty() ? "the document" : in_quotes(first.pointer);
    if (problems.size() == 1) return "the job is not valid: " + place + " " + first.message;
    return "the job has " + std::to_string(problems.size()) + " problems; the first: " + place +
           " " + first.message;
}

}  // namespace

InvalidJob::InvalidJob(std::vector<Problem> found)
    : Error("invalid_job", summary(found)), problems(std::move(found)) {}

JobSpec parse_job(std::string_view text) {
    const Json given = parse_json(text, {limits().job_bytes_max, limits().depth_max});
    ProblemList problems(static_cast<std::size_t>(limits().problems_max));
    const Json& schema = contract()["components"]["schemas"]["Job"];
    const Json document = walk_schema(contract(), schema, given, problems);
    JobSpec job = Reader(given, document, problems).read();
    if (!problems.empty()) throw InvalidJob(problems.take());
    return job;
}

}  // namespace kiln
