// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace kiln {

// The closed sets of a job. Each enumerator's word in JSON is its own name (see words.h).
enum class Quantity {
    split_sum_scale,
    split_sum_bias,
    directional_albedo,
    average_albedo,
    multiscatter_albedo,
};
enum class Parameter { NoV, roughness, alpha };
enum class Mapping { linear, sqrt, square };
enum class Grid { center, node };
enum class Sampler { hammersley, sobol_owen, lattice, random };
enum class Importance { vndf, ndf };
enum class Distribution { ggx };
enum class Masking { smith_correlated, smith_separable };
enum class Precision { float32, float64 };
enum class DeviceChoice { automatic, opencl, native };  // "auto" in JSON
enum class ImageFormat { exr, png };
enum class PixelType {
    half,
    float32,
    uint8,
    uint16
};  // "half", "float", "uint8", "uint16" in JSON

/// One axis of a table: which parameter it carries and where texel i of n lies on it.
struct Axis {
    Parameter parameter = Parameter::NoV;
    Mapping mapping = Mapping::linear;
    Grid grid = Grid::center;
    bool flip = false;
    double lo = 0;  ///< parameter value at the start of the axis, in [0, 1]
    double hi = 1;  ///< parameter value at its end, > lo, in [0, 1]
    bool operator==(const Axis&) const = default;
};

/// A job past the gate: every field is set and every combination makes sense.
struct JobSpec {
    std::vector<Quantity> quantities;  ///< 1…64, no repeats; they become channels in this order
    std::vector<std::int64_t> resolution;  ///< [x] or [x, y], each 1…4096
    std::string layout = "kiln";  ///< preset name, or "custom" when the document gave an object
    std::vector<Axis> axes;  ///< as many as resolution has entries; row 0 is the first texel of y
    std::int64_t sample_count = 1024;  ///< samples a texel in all replicates together
    Sampler sampler = Sampler::sobol_owen;
    Importance importance = Importance::vndf;
    Distribution distribution = Distribution::ggx;
    Masking masking = Masking::smith_correlated;
    Precision precision = Precision::float32;
    DeviceChoice device = DeviceChoice::automatic;
    std::uint64_t seed = 0;  ///< below 2^53, so that every JSON reader keeps it
    ImageFormat format = ImageFormat::exr;
    PixelType pixel = PixelType::half;
    bool operator==(const JobSpec&) const = default;
};

}  // namespace kiln
