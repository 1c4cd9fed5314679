// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

/// Measured files of materials whose reflectance is known, written by rules that share nothing
/// with the readers but the formats.
namespace kiln::synthetic {

/// f_r in 1/sr, R, G, B, from the cosines that an isotropic model needs.
struct Cosines {
    double NoL = 0, NoV = 0, NoH = 0, VoH = 0;
};
using Material = std::function<std::array<double, 3>(const Cosines&)>;

Material lambert(std::array<double, 3> albedo);
/// GGX with Smith's height-correlated masking and Schlick's Fresnel term, over a Lambertian base.
Material ggx(double alpha, std::array<double, 3> f0, std::array<double, 3> diffuse);

/// Cosines for angles in degrees; light at azimuth 0, view at `phi`.
Cosines cosines(double theta_i, double theta_o, double phi);

std::string merl_file(const Material& material, int azimuths = 180);

struct MiniDiffGrid {
    std::vector<double> aoi{0, 20, 40, 60};
    double azimuth_step = 1, radial_step = 1, radial_max = 75;
    double light_azimuth = 90;
    std::string model = "synthetic";
};
/// Values with seven digits.
std::string minidiff_file(const Material& material, const MiniDiffGrid& grid = {});

/// One surface as the two programs of LOFT's scatterometer wrote it, in the angles of those files:
/// about the mirror direction in steps of 10 degrees of azimuth, four digits; absolute in steps of
/// 5 and 10 degrees to 80, six decimals. The values are red.
std::string zemax_file(const Material& material);
std::string fred_file(const Material& material);

/// A field of a file in RGL's container.
struct TensorPart {
    std::string name;
    std::uint8_t type;  ///< 1 u8, 10 f32
    std::vector<std::uint64_t> shape;
    std::string data;
};
std::string tensor_file(const std::vector<TensorPart>& parts);

/// What an RGL file is besides a surface: the red of it times a reflectance at some wavelengths, or
/// the same in R, G and B where none are given.
struct RglLayout {
    std::vector<double> nanometres;
    double (*reflectance)(double nanometres) = nullptr;
    std::size_t nodes = 33;         ///< along each side of a table
    std::vector<double> phi_in{0};  ///< degrees; more than two for a surface that turns
    std::optional<char> mask = {};  ///< each byte of `valid`; else bit 1 is above the horizon
};
/// f cos theta_o under five theta_in to 80 degrees, at half vectors.
std::string rgl_file(const Material& surface, const RglLayout& layout);

/// A surface whose normals lie along x and y to different extents: GGX of two widths with Smith's
/// height-correlated masking, all of it reflected by f0 (Schlick), over a Lambertian base.
struct Brushed {
    double alpha_x = 0.2, alpha_y = 0.5, f0 = 0.5, diffuse = 0.2;
    /// f_r in 1/sr; degrees, azimuths as the surface lies.
    double operator()(double theta_i, double phi_i, double theta_o, double phi_o) const;
};
std::string rgl_file(const Brushed& surface, const RglLayout& layout);
/// Columns theta_in, phi_in, theta_out, phi_out and r, to 75 degrees of the view.
std::string csv_file(const Brushed& surface, const std::vector<double>& theta_in,
                     const std::vector<double>& phi_in, double step);

/// A file of few values for each reader, valid as it is: where mutations start.
std::string small_file(std::string_view reader);

}  // namespace kiln::synthetic
