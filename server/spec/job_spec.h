// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "server/spec/diffuse_words.h"  // cmake/Words.cmake
#include "server/spec/fresnel_spec.h"
#include "server/spec/measured_spec.h"

namespace kiln {

// The closed sets of a job. Each enumerator's word in JSON is its own name (see words.h).
enum class Kind {
    lut,
    convergence,
    stability,
    furnace,
    slices,
    atlas,
    lobe_view,
    sphere_view,
    companion,
    sampling,
};
enum class Quantity {
    split_sum_scale,
    split_sum_bias,
    directional_albedo,
    average_albedo,
    multiscatter_albedo,
    specular_albedo,
    compensated_albedo,
    fresnel_average,
    diffuse_albedo,
    diffuse_average_albedo,
    total_albedo,
};
enum class Parameter { NoV, roughness, alpha, f0, ior };
enum class Mapping { linear, sqrt, square };
enum class Grid { center, node };
enum class Integrator { monte_carlo, quadrature };
enum class Sampler { hammersley, sobol_owen, lattice, random };
// The numbers of the next three are those of the kernels (kernels/microfacet.h), as are
// DiffuseModel's from lambert on (kernels/diffuse.h).
enum class Importance { vndf, ndf, cosine, uniform };
enum class Distribution { ggx, beckmann, charlie };
enum class Masking {
    smith_correlated,
    smith_separable,
    karis_ibl,
    karis_direct,
    unreal_joint,
    neubelt,
    charlie
};
#define KILN_ENUMERATOR(word) word,
/// none, then the lobes. ggx_lambert alone is no function but the light that walks over facets.
enum class DiffuseModel { KILN_DIFFUSE_WORDS(KILN_ENUMERATOR) };
#undef KILN_ENUMERATOR
enum class Coupling { none, half_vector, view, kelemen };
/// kulla_conty_linear has F_avg where kulla_conty has F_avg², as older slides have it.
enum class Multiscatter { none, kulla_conty, kulla_conty_linear, turquin };
enum class Precision { float32, float64 };
enum class DeviceChoice { automatic, opencl, native };  // "auto" in JSON
enum class ImageFormat { exr, png };
enum class PixelType {
    half,
    float32,
    uint8,
    uint16,
    rgb9e5  ///< three colours in 32 bits (server/base/rgb9e5.h)
};          // "half", "float", "uint8", "uint16", "rgb9e5" in JSON

/// One axis of a table: which parameter it carries and where texel i of n lies on it.
struct Axis {
    Parameter parameter = Parameter::NoV;
    Mapping mapping = Mapping::linear;
    Grid grid = Grid::center;
    bool flip = false;
    double lo = 0;  ///< parameter value at the start of the axis, in [0, 1]
    double hi = 1;  ///< parameter value at its end, > lo, in [0, 1]
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
