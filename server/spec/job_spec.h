// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "server/spec/closed_sets.h"  // cmake/Words.cmake
#include "server/spec/fresnel_spec.h"
#include "server/spec/measured_spec.h"

namespace kiln {

// The closed sets of a job, Kind to PixelType, are the contract's: cmake/Words.cmake makes them.
// The numbers of Importance, Distribution and Masking are those of the kernels, as are
// DiffuseModel's from lambert on.

/// One axis of a table: which parameter it carries and where texel i of n lies on it.
struct Axis {
    Parameter parameter = Parameter::NoV;
    Mapping mapping = Mapping::linear;
    Grid grid = Grid::center;
    bool flip = false;
    double lo = 0;  ///< parameter value at the start of the axis, in [0, 1]
    double hi = 1;  ///< parameter value at its end, > lo, in [0, 1]
    /// Of z: the parameter of each slice where they are listed; lo and hi are then their bounds and
    /// mapping, grid and flip say nothing.
    std::vector<double> values{};
    // Presets alone have these (layouts.h); no document spells them.
    double shift = 0;  ///< texels by which t lies above where grid and flip put it
    double least = 0;  ///< smaller parameter values are raised to this
    double most = std::numeric_limits<double>::infinity();  ///< larger ones are lowered to this
    // Only where a table is checked (server/compute/lattice.h).
    std::vector<double> at{};  ///< places along the axis, in texels, instead of 0, 1, 2, …
    std::int64_t of = 0;       ///< texels that `at` counts
    bool operator==(const Axis&) const = default;
};

/// The diffuse lobe.
struct DiffuseSpec {
    DiffuseModel model = DiffuseModel::lambert;
    std::vector<double> albedo{1.0};  ///< one for all channels or three, each in [0, 1]
    bool operator==(const DiffuseSpec&) const = default;
};

/// A job past the gate: every field is set and every combination makes sense.
struct JobSpec {
    Kind kind = Kind::lut;
    /// 1…64, no repeats; they become channels in this order. Empty for a stability study and for
    /// measured kinds.
    std::vector<Quantity> quantities;
    std::vector<std::int64_t> resolution;  ///< [x] or [x, y], each 1…4096
    std::string layout = "kiln";           ///< preset name (layouts.h); "custom": an object
    std::vector<Axis> axes;  ///< as many as resolution has entries; row 0 is the first texel of y
    /// Samples a texel in all replicates together; with one of the next two, the most.
    std::int64_t sample_count = 1024;
    std::optional<double> target_error;   ///< bound on each texel's error at which sampling stops
    std::optional<double> time_budget_s;  ///< of integration
    Integrator integrator = Integrator::monte_carlo;
    Sampler sampler = Sampler::sobol_owen;
    Importance importance = Importance::vndf;
    Distribution distribution = Distribution::ggx;
    Masking masking = Masking::smith_correlated;
    bool terminator_softening = false;  ///< of Masking::charlie
    FresnelModel fresnel;
    DiffuseSpec diffuse;
    Coupling coupling = Coupling::none;
    Multiscatter multiscatter = Multiscatter::none;
    Precision precision = Precision::float32;
    DeviceChoice device = DeviceChoice::automatic;
    std::uint64_t seed = 0;  ///< below 2^53, so that every JSON reader keeps it
    ImageFormat format = ImageFormat::exr;
    PixelType pixel = PixelType::half;
    MeasuredSpec measured;  ///< of kind slices and atlas, whose resolution is that of a slice
    bool operator==(const JobSpec&) const = default;
};

}  // namespace kiln
