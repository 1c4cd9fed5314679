// SPDX-License-Identifier: Apache-2.0
#include "server/spec/words.h"

namespace kiln {
namespace {

using Word = std::string_view;
constexpr Word kKind[] = {"lut",   "convergence", "stability",   "furnace",   "slices",
                          "atlas", "lobe_view",   "sphere_view", "companion", "sampling"};
constexpr Word kQuantity[] = {"split_sum_scale",        "split_sum_bias",      "directional_albedo",
                              "average_albedo",         "multiscatter_albedo", "specular_albedo",
                              "compensated_albedo",     "fresnel_average",     "diffuse_albedo",
                              "diffuse_average_albedo", "total_albedo"};
constexpr Word kParameter[] = {"NoV", "roughness", "alpha", "f0", "ior"};
constexpr Word kMapping[] = {"linear", "sqrt", "square"};
constexpr Word kGrid[] = {"center", "node"};
constexpr Word kIntegrator[] = {"monte_carlo", "quadrature"};
constexpr Word kSampler[] = {"hammersley", "sobol_owen", "lattice", "random"};
constexpr Word kImportance[] = {"vndf", "ndf", "cosine", "uniform"};
constexpr Word kDistribution[] = {"ggx", "beckmann", "charlie"};
constexpr Word kMasking[] = {"smith_correlated", "smith_separable", "karis_ibl", "karis_direct",
                             "unreal_joint",     "neubelt",         "charlie"};
constexpr Word kFresnel[] = {"none", "schlick", "dielectric", "conductor", "edge_tint", "f82_tint"};
constexpr Word kMetal[] = {"aluminium", "chromium", "copper", "gold",     "iron",
                           "nickel",    "platinum", "silver", "titanium", "tungsten"};
#define KILN_SPELLED(word) #word,
constexpr Word kDiffuseModel[] = {KILN_DIFFUSE_WORDS(KILN_SPELLED)};
constexpr Word kCoupling[] = {"none", "half_vector", "view", "kelemen"};
constexpr Word kMultiscatter[] = {"none", "kulla_conty", "kulla_conty_linear", "turquin"};
constexpr Word kPrecision[] = {"float32", "float64"};
constexpr Word kDeviceChoice[] = {"auto", "opencl", "native"};
constexpr Word kImageFormat[] = {"exr", "png"};
constexpr Word kPixelType[] = {"half", "float", "uint8", "uint16", "rgb9e5"};
constexpr Word kThetaInBeyond[] = {"clamp", "reciprocity"};

}  // namespace

// clang-format off
template <> std::span<const Word> words<Kind>() { return kKind; }
template <> std::span<const Word> words<Quantity>() { return kQuantity; }
template <> std::span<const Word> words<Parameter>() { return kParameter; }
template <> std::span<const Word> words<Mapping>() { return kMapping; }
template <> std::span<const Word> words<Grid>() { return kGrid; }
template <> std::span<const Word> words<Integrator>() { return kIntegrator; }
template <> std::span<const Word> words<Sampler>() { return kSampler; }
template <> std::span<const Word> words<Importance>() { return kImportance; }
template <> std::span<const Word> words<Distribution>() { return kDistribution; }
template <> std::span<const Word> words<Masking>() { return kMasking; }
template <> std::span<const Word> words<Fresnel>() { return kFresnel; }
template <> std::span<const Word> words<Metal>() { return kMetal; }
template <> std::span<const Word> words<DiffuseModel>() { return kDiffuseModel; }
template <> std::span<const Word> words<Coupling>() { return kCoupling; }
template <> std::span<const Word> words<Multiscatter>() { return kMultiscatter; }
template <> std::span<const Word> words<Precision>() { return kPrecision; }
template <> std::span<const Word> words<DeviceChoice>() { return kDeviceChoice; }
template <> std::span<const Word> words<ImageFormat>() { return kImageFormat; }
template <> std::span<const Word> words<PixelType>() { return kPixelType; }
template <> std::span<const Word> words<ThetaInBeyond>() { return kThetaInBeyond; }
// clang-format on

std::vector<DiffuseModel> diffuse_lobes() {
    std::vector<DiffuseModel> lobes;
    for (std::size_t i = 0; i < words<DiffuseModel>().size(); ++i) {
        const auto model = static_cast<DiffuseModel>(i);
        if (model != DiffuseModel::none && model != DiffuseModel::ggx_lambert)
            lobes.push_back(model);
    }
    return lobes;
}

}  // namespace kiln
