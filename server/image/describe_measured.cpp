// SPDX-License-Identifier: Apache-2.0
#include "server/image/describe_measured.h"

#include "server/base/version.h"
#include "server/image/describing.h"
#include "server/spec/pixel_words.h"
#include "server/spec/slice_grid.h"
#include "server/spec/spec.h"
#include "server/spec/words.h"

namespace kiln {
namespace {

using describing::number;

/// One line a fact, of each kind that is a table.
std::vector<std::string> channel_lines(Kind kind) {
    if (kind == Kind::companion)
        return {"R, G, B: E(NoV), what leaves towards the view under even light of 1, linear sRGB",
                "A: share of E that is extrapolated"};
    if (kind == Kind::sampling)
        return {"R: running sum of the rings' probabilities, to this ring's end",
                "G: running sum of the ring's cells, to this cell's end",
                "B: probability of the cell"};
    return {"R, G, B: f_r in 1/sr, linear sRGB, no cosine",
            "origin: 0 measured, 1 interpolated, 2 extrapolated, 3 below the horizon"};
}

std::vector<std::string> axis_lines(const JobSpec& job) {
    if (job.kind == Kind::companion)
        return {"x: NoV, linear 0..1 at texel centres: NoV = (x + 0.5) / " +
                    std::to_string(job.resolution[0]),
                "y: a row a material"};
    if (job.kind == Kind::sampling)
        return {"column of a slice: a cell of 360 / " + std::to_string(job.resolution[0]) +
                    " degrees of phi_d",
                "row k of a slice: a ring about the mirror direction; from k / m to (k + 1) / m of "
                "sqrt(sin(theta_d / 2) / h), m = " +
                    std::to_string(job.resolution[1]) + ", h = sin(theta_d / 2) at the horizon"};
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

/// "" where there are none.
std::string slice_line(const JobSpec& job) {
    if (job.kind == Kind::companion) return "";
    const SliceGrid grid = slice_grid(job);
    std::string angles;
    for (const double angle : job.measured.theta_in)
        angles += (angles.empty() ? "" : " ") + number(angle);
    const std::string row = std::to_string(grid.slice_columns);
    if (job.kind == Kind::sampling)
        return "slices: theta_in " + angles + " degrees, " + row + " in a row";
    return "slices: theta_in " + angles + " degrees, " + row + " in a row; each of " +
           std::to_string(grid.cell_columns) + " x " + std::to_string(grid.cell_rows) +
           " cells of " + std::to_string(grid.cell_width) + " x " +
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
    Metadata lines = {{"kiln.job", canonical(job)},
                      {"kiln.kind", std::string(to_word(job.kind))},
                      {"kiln.channels", joined(channel_lines(job.kind))},
                      {"kiln.axes", joined(axis_lines(job))},
                      {"kiln.slices", slice_line(job)},
                      {"kiln.measurements", materials},
                      {"kiln.pixel", pixel_words(job.format, job.pixel, job.kind)},
                      {"kiln.version", kVersion},
                      {"kiln.kernel_digest", provenance.kernel_digest},
                      {"kiln.encoder_revision", std::to_string(kEncoderRevision)},
                      {"kiln.numerics", provenance.numerics},
                      {"kiln.key", provenance.key},
                      {"kiln.color", "linear data, no transfer function"}};
    std::erase_if(lines, [](const auto& line) { return line.second.empty(); });
    return lines;
}

std::vector<std::string> measured_convention(const JobSpec& job) {
    std::vector<std::string> lines = axis_lines(job);
    if (const std::string slices = slice_line(job); !slices.empty()) lines.push_back(slices);
    const char* place = job.kind == Kind::companion ? "row " : "cell ";
    for (std::size_t m = 0; m < job.measured.materials.size(); ++m)
        lines.push_back(place + std::to_string(m) + ": " + job.measured.materials[m].name +
                        ", sha256:" + job.measured.materials[m].data);
    for (std::string& line : channel_lines(job.kind)) lines.push_back(std::move(line));
    lines.push_back("pixel: " + pixel_words(job.format, job.pixel, job.kind));
    return lines;
}

}  // namespace kiln
