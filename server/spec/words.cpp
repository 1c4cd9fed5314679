// SPDX-License-Identifier: Apache-2.0
#include "server/spec/words.h"

namespace kiln {
namespace {

using Word = std::string_view;
constexpr Word kQuantity[] = {"split_sum_scale", "split_sum_bias", "directional_albedo",
                              "average_albedo", "multiscatter_albedo"};
constexpr Word kParameter[] = {"NoV", "roughness", "alpha"};
constexpr Word kMapping[] = {"linear", "sqrt", "square"};
constexpr Word kGrid[] = {"center", "node"};
constexpr Word kSampler[] = {"hammersley", "sobol_owen", "lattice", "random"};
constexpr Word kImportance[] = {"vndf", "ndf"};
constexpr Word kDistribution[] = {"ggx"};
constexpr Word kMasking[] = {"smith_correlated", "smith_separable"};
constexpr Word kPrecision[] = {"float32", "float64"};
constexpr Word kDeviceChoice[] = {"auto", "opencl", "native"};
constexpr Word kImageFormat[] = {"exr", "png"};
constexpr Word kPixelType[] = {"half", "float", "uint8", "uint16"};

}  // namespace

// clang-format off
template <> std::span<const Word> words<Quantity>() { return kQuantity; }
template <> std::span<const Word> words<Parameter>() { return kParameter; }
template <> std::span<const Word> words<Mapping>() { return kMapping; }
template <> std::span<const Word> words<Grid>() { return kGrid; }
template <> std::span<const Word> words<Sampler>() { return kSampler; }
template <> std::span<const Word> words<Importance>() { return kImportance; }
template <> std::span<const Word> words<Distribution>() { return kDistribution; }
template <> std::span<const Word> words<Masking>() { return kMasking; }
template <> std::span<const Word> words<Precision>() { return kPrecision; }
template <> std::span<const Word> words<DeviceChoice>() { return kDeviceChoice; }
template <> std::span<const Word> words<ImageFormat>() { return kImageFormat; }
template <> std::span<const Word> words<PixelType>() { return kPixelType; }
// clang-format on

bool depends_on_NoV(Quantity quantity) { return quantity != Quantity::average_albedo; }

}  // namespace kiln
