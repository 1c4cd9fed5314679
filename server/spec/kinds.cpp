// SPDX-License-Identifier: Apache-2.0
#include "server/spec/kinds.h"

#include <algorithm>
#include <span>

#include "server/spec/layouts.h"

namespace kiln {

namespace {

using Field = std::string_view;
// A convergence study goes through every sampler, importance and backend that there is.
constexpr Field kConvergence[] = {
    "kind",    "quantities", "resolution",   "layout",    "sample_count", "microfacet", "fresnel",
    "diffuse", "coupling",   "multiscatter", "precision", "device",       "seed"};
constexpr Field kStability[] = {"kind", "device", "seed"};
// Angles and roughnesses of a furnace study are its own.
constexpr Field kFurnace[] = {"kind",         "sample_count", "sampler", "importance",
                              "microfacet",   "fresnel",      "diffuse", "coupling",
                              "multiscatter", "precision",    "device",  "seed"};

constexpr Field kMeasured[] = {"kind", "measured", "resolution", "device", "output"};
constexpr Field kView[] = {"kind", "measured", "resolution", "device"};

bool holds(std::span<const Field> fields, Field field) {
    return std::find(fields.begin(), fields.end(), field) != fields.end();
}

}  // namespace

bool is_read(Kind kind, std::string_view field) {
    switch (kind) {
        case Kind::lut:
            return field != "measured";
        case Kind::convergence:
            return holds(kConvergence, field);
        case Kind::stability:
            return holds(kStability, field);
        case Kind::furnace:
            return holds(kFurnace, field);
        case Kind::slices:
        case Kind::atlas:
        case Kind::companion:
        case Kind::sampling:
            return holds(kMeasured, field);
        case Kind::lobe_view:
        case Kind::sphere_view:
            return holds(kView, field);
    }
    return false;
}

bool is_sliced(Kind kind) { return kind == Kind::slices || kind == Kind::atlas; }

bool is_view(Kind kind) { return kind == Kind::lobe_view || kind == Kind::sphere_view; }

bool is_measured(Kind kind) {
    return is_sliced(kind) || is_view(kind) || kind == Kind::companion || kind == Kind::sampling;
}

bool is_read_of_measured(Kind kind, std::string_view field) {
    if (field == "theta_in")
        return is_sliced(kind) || kind == Kind::lobe_view || kind == Kind::sampling;
    if (field == "gutter" || field == "fit_error_max") return is_sliced(kind);
    return is_measured(kind);
}

void prepare_study(JobSpec& job) {
    job.format = ImageFormat::png;
    job.pixel = PixelType::uint8;
    if (job.kind == Kind::convergence) job.integrator = Integrator::quadrature;  // its reference
    if (job.kind == Kind::furnace) {
        job.quantities = {Quantity::total_albedo};
        job.resolution = {kFurnaceAngles, kFurnaceRoughnesses};
        job.axes = layout_preset(JobSpec{}.layout)->axes;
        // A mirror's lobe is no function.
        job.axes[1].lo = 0.1;
        job.axes[1].grid = Grid::node;
        job.layout = "custom";
    }
}

}  // namespace kiln
