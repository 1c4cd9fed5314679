// SPDX-License-Identifier: Apache-2.0
#include "server/image/describe_measured.h"

#include <charconv>

#include "server/base/version.h"
#include "server/spec/pixel_words.h"
#include "server/spec/slice_grid.h"
#include "server/spec/spec.h"
#include "server/spec/words.h"

namespace kiln {
namespace {

constexpr const char* kChannels =
    "R, G, B: f_r in 1/sr, linear sRGB, no cosine\n"
    "origin: 0 measured, 1 interpolated, 2 extrapolated, 3 below the horizon";

std::string number(double value) {
    char text[32];
    const auto end = std::to_chars(text, text + sizeof text, value).ptr;
    return {text, end};
}

std::vector<std::string> axis_lines(const JobSpec& job) {
    const std::string w = std::to_string(job.resolution[0] - 1);
    const std::string h = std::to_string(job.resolution[1] - 1);
    return {"column c of a slice: phi_d = 360 c / " + w +
                " degrees; look up at c + 0.5 texels, c = "
                "phi_d / 360 * " +
                w,
            "row r of a slice: theta_d = 180 r / " + h +
                " degrees; look up at r + 0.5 texels, r = "
                "theta_d / 180 * " +
                h,
            "theta_d, phi_d: polar angles of the view about the mirror direction of the light, "
            "theta_d = 0 there (Cezner 2024)"};
}

std::string slice_line(const JobSpec& job) {
    const SliceGrid grid = slice_grid(job);
    std::string angles;
    for (const double angle : job.measured.theta_in)
        angles += (angles.empty() ? "" : " ") + number(angle);
    return "slices: theta_in " + angles + " degrees, " + std::to_string(grid.slice_columns) +
           " in a row; each of " + std::to_string(grid.cell_columns) + " x " +
           std::to_string(grid.cell_rows) + " cells of " + std::to_string(grid.cell_width) + " x " +
           std::to_string(grid.cell_height) + " texels with a gutter of " +
           std::to_string(job.measured.gutter);
}

std::string joined(const std::vector<std::string>& lines) {
    std::string text;
    for (const std::string& line : lines) text += (text.empty() ? "" : "\n") + line;
    return text;
}

}  // namespace

Metadata describe_measured(const JobSpec& job, const Provenance& provenance) {
    std::string materials;
    for (const MeasuredMaterial& material : job.measured.materials)
        materials +=
            (materials.empty() ? "" : "\n") + std::string(kMeasurementPrefix) + material.data;
    return {{"kiln.job", canonical(job)},
            {"kiln.kind", std::string(to_word(job.kind))},
            {"kiln.channels", kChannels},
            {"kiln.axes", joined(axis_lines(job))},
            {"kiln.slices", slice_line(job)},
            {"kiln.measurements", materials},
            {"kiln.pixel", pixel_words(job.format, job.pixel)},
            {"kiln.version", kVersion},
            {"kiln.kernel_digest", provenance.kernel_digest},
            {"kiln.encoder_revision", std::to_string(kEncoderRevision)},
            {"kiln.numerics", provenance.numerics},
            {"kiln.key", provenance.key},
            {"kiln.color", "linear data, no transfer function"}};
}

std::vector<std::string> measured_convention(const JobSpec& job) {
    std::vector<std::string> lines = axis_lines(job);
    lines.push_back(slice_line(job));
    for (std::size_t m = 0; m < job.measured.materials.size(); ++m)
        lines.push_back("cell " + std::to_string(m) + ": " + job.measured.materials[m].name +
                        ", sha256:" + job.measured.materials[m].data);
    lines.emplace_back("R, G, B: f_r in 1/sr, linear sRGB, no cosine");
    lines.push_back("pixel: " + pixel_words(job.format, job.pixel));
    return lines;
}

}  // namespace kiln
