// SPDX-License-Identifier: Apache-2.0
// `measure`: what looks at measured reflectance.
#include <cstdio>
#include <filesystem>

#include "client/commands.h"
#include "client/files.h"
#include "client/measurements.h"
#include "client/terminal.h"
#include "server/measured/bounds.h"
#include "server/measured/slices.h"
#include "server/measured/survey.h"
#include "server/spec/limits.h"
#include "server/spec/spec.h"
#include "server/worker/bake.h"

namespace kiln::client {

namespace {

using namespace measured;

void print(const std::string& line) { std::printf("%s\n", printable(line).c_str()); }

std::string percent(double share) { return format_number(100 * share) + " %"; }

/// A table of incidences; of many, the first azimuth of each theta_in.
void print_incidences(const ComponentSurvey& part) {
    constexpr std::size_t kChannelsShown = 4;
    std::vector<std::vector<std::string>> rows{{"theta_in", "phi_in", "points", "measured"}};
    const std::size_t channels = std::min(part.channels.size(), kChannelsShown);
    for (std::size_t c = 0; c < channels; ++c) rows[0].push_back("albedo " + part.channels[c]);
    const IncidenceSurvey* last = nullptr;
    for (const IncidenceSurvey& one : part.incidences) {
        if (last && last->theta_i == one.theta_i) continue;
        last = &one;
        rows.push_back({format_number(one.theta_i), format_number(one.phi_i),
                        std::to_string(one.points), percent(one.coverage)});
        for (std::size_t c = 0; c < channels; ++c)
            rows.back().push_back(one.coverage > 0 ? format_number(one.albedo[c]) : "-");
    }
    for (const std::string& line : columns(rows)) print("  " + line);
}

void print_component(const ComponentSurvey& part) {
    print("");
    print(part.name + ": " + std::to_string(part.points) + " points, " +
          std::to_string(part.usable) + " usable (" + std::to_string(part.mirrored) +
          " mirrored), " + std::to_string(part.not_measured) + " not measured, " +
          std::to_string(part.below_horizon) + " below the horizon, " +
          std::to_string(part.rejected) + " rejected");
    print("  values " + format_number(part.value_min) + " to " + format_number(part.value_max) +
          " 1/sr, theta_out to " + format_number(part.theta_out_max) + " degrees");
    if (part.reciprocity.pairs > 0)
        print("  f(i,o) and f(o,i) differ by " + percent(part.reciprocity.median) + " (median), " +
              percent(part.reciprocity.p95) + " (95th percentile) in " +
              std::to_string(part.reciprocity.pairs) + " pairs");
    print_incidences(part);
}

Reading read_file(const std::string& path) {
    const std::string bytes = read_input(path, kFileBytesMax);
    try {
        return read_measurement(bytes);
    } catch (const Error& error) {
        throw Failure(Exit::usage, error.code(), path + ": " + error.what());
    }
}

SliceLayout layout_of(const SliceOptions& options) {
    SliceLayout layout;
    if (!options.theta_in.empty()) layout.theta_in = options.theta_in;
    const auto most_angles = static_cast<std::size_t>(limits().slice_count_max);
    const auto most_materials = static_cast<std::size_t>(limits().atlas_materials_max);
    const auto wrong = [](const std::string& what) { return Failure(Exit::usage, "usage", what); };
    if (layout.theta_in.size() > most_angles)
        throw wrong("--theta-in: at most " + std::to_string(most_angles) + " angles");
    for (std::size_t n = 0; n < layout.theta_in.size(); ++n)
        if (!(layout.theta_in[n] >= 0 && layout.theta_in[n] <= 90) ||
            (n > 0 && layout.theta_in[n] <= layout.theta_in[n - 1]))
            throw wrong("--theta-in: give rising angles from 0 to 90 degrees");
    if (options.files.size() > most_materials)
        throw wrong("an atlas holds at most " + std::to_string(most_materials) + " materials");
    layout.width = options.width;
    layout.height = options.height;
    layout.gutter = options.gutter;
    return layout;
}

/// As a job has names of materials: at most 64 characters.
std::string name_of(const std::string& path) {
    constexpr std::size_t kNameMax = 64;
    const std::string name = printable(std::filesystem::path(path).filename().string());
    std::size_t end = std::min(name.size(), kNameMax);
    while (end > 0 && end < name.size() && (name[end] & 0xc0) == 0x80) --end;  // UTF-8 goes on
    return name.substr(0, end);
}

/// The job that files and options make.
JobSpec job_of(const SliceOptions& options, const SliceLayout& layout, MeasurementFiles& files) {
    const std::string extension = extension_of(options.output);
    if (extension != "exr" && extension != "png")
        throw Failure(Exit::usage, "usage", "-o: name a file that ends in .exr or .png");
    JobSpec job;
    job.kind = options.files.size() > 1 ? Kind::atlas : Kind::slices;
    job.resolution = {static_cast<std::int64_t>(layout.width),
                      static_cast<std::int64_t>(layout.height)};
    for (const std::string& path : options.files)
        job.measured.materials.push_back(
            {files.add(path), name_of(path), options.extrapolation, options.phi_in});
    job.measured.theta_in = layout.theta_in;
    job.measured.gutter = static_cast<std::int64_t>(layout.gutter);
    job.format = extension == "exr" ? ImageFormat::exr : ImageFormat::png;
    job.pixel = extension == "exr" ? PixelType::half : PixelType::uint16;
    return parse_job(canonical(job));  // holds it to the contract
}

}  // namespace

Exit measure_slices(const SliceOptions& options) {
    const SliceLayout layout = layout_of(options);
    plan_slices(layout, options.files.size());
    check_output(options.output);
    MeasurementFiles files;
    const JobSpec job = job_of(options, layout, files);
    EngineOptions native;
    native.device = DeviceChoice::native;
    Engine engine(native);
    Baked made;
    try {
        made = kiln::bake(engine, job, {},
                          [&files](const std::string& digest) { return files.bytes(digest); });
    } catch (const Failure&) {
        throw;
    } catch (const Error& error) {  // of a file: the job is one of ours
        throw Failure(Exit::usage, error.code(), error.what());
    }
    for (const std::string& warning : made.report.warnings) say("kiln: " + printable(warning));
    write_output(options.output, made.image);
    if (!options.sidecar.empty()) write_output(options.sidecar, made.sidecar + "\n");
    if (options.json) std::printf("%s\n", made.sidecar.c_str());
    return Exit::done;
}

Exit measure_info(const std::string& path, bool json) {
    const Reading reading = read_file(path);
    std::vector<ComponentSurvey> parts;
    for (const Component& component : reading.components) parts.push_back(survey(component));
    const Understood& account = reading.understood;
    if (json) {
        std::printf("%s\n", account_json(account, parts).c_str());
        return Exit::done;
    }
    print(path + "  " + account.format + (account.title.empty() ? "" : "  " + account.title));
    print("");
    for (const Finding& finding : account.findings)
        print(finding.what + ": " + finding.value + " (" + finding.evidence + ")");
    for (const measured::LeftOut& left : account.left_out)
        print("left out: " + left.what + ": " + left.why);
    for (const std::string& warning : account.warnings) print("warning: " + warning);
    for (const ComponentSurvey& part : parts) print_component(part);
    print("");
    print("Albedo is the integral of f cos(theta_out) over the measured part of the hemisphere.");
    return Exit::done;
}

}  // namespace kiln::client
