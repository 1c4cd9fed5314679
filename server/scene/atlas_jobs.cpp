// SPDX-License-Identifier: Apache-2.0
#include "server/scene/atlas_jobs.h"

#include <algorithm>
#include <numbers>
#include <span>

#include "server/spec/limits.h"
#include "server/spec/slice_grid.h"
#include "server/spec/spec.h"
#include "server/spec/words.h"

namespace kiln {

namespace {

/// A BRDF has no upper bound, so it is never stored as integers, which end at 1.
PixelType pixel_of(const PlanOptions& options) {
    return options.format == ImageFormat::png ? PixelType::rgb9e5 : options.pixel;
}

JobSpec atlas_job(std::span<const std::string> ids, const PlanOptions& options) {
    std::string data;
    for (const std::string& id : ids) data += (data.empty() ? "\"" : ",\"") + id + "\"";
    return parse_job(R"({"kind":"atlas","measured":{"data":[)" + data +
                     R"(]},"output":{"format":")" + std::string(to_word(options.format)) +
                     R"(","pixel":")" + std::string(to_word(pixel_of(options))) + R"("}})");
}

}  // namespace

std::vector<JobSpec> atlas_jobs(std::vector<std::string> ids, const PlanOptions& options) {
    if (ids.empty()) return {};
    std::sort(ids.begin(), ids.end());
    JobSpec largest = atlas_job(std::span(ids).first(1), options);
    std::vector<MeasuredMaterial>& cells = largest.measured.materials;
    cells.resize(static_cast<std::size_t>(limits().atlas_materials_max));
    while (cells.size() > 1 && too_large(slice_grid(largest))) cells.pop_back();
    const std::size_t most = cells.size();
    std::vector<JobSpec> jobs;
    for (std::size_t first = 0; first < ids.size(); first += most)
        jobs.push_back(
            atlas_job(std::span(ids).subspan(first, std::min(most, ids.size() - first)), options));
    return jobs;
}

std::vector<SliceLookup> slice_lookups(const JobSpec& atlas, std::size_t cell) {
    const SliceGrid grid = slice_grid(atlas);
    // The texel centres of both ends of an angle are a step less apart than there are texels.
    const auto along = [](std::int64_t texels, double turn, std::size_t first, std::size_t size) {
        const auto whole = static_cast<double>(size);
        return AngleLookup{static_cast<double>(texels - 1) / turn / whole,
                           (static_cast<double>(first) + 0.5) / whole};
    };
    std::vector<SliceLookup> slices;
    for (std::size_t s = 0; s < atlas.measured.theta_in.size(); ++s) {
        const SliceGrid::Place at =
            grid.place(s, cell, static_cast<std::size_t>(atlas.measured.gutter));
        slices.push_back({atlas.measured.theta_in[s],
                          along(atlas.resolution[0], 2 * std::numbers::pi, at.x, grid.width()),
                          along(atlas.resolution[1], std::numbers::pi, at.y, grid.height())});
    }
    return slices;
}

}  // namespace kiln
