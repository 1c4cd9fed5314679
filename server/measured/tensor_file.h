// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace kiln::measured {

/// A field of a tensor file: C order, little endian, within the file.
struct TensorField {
    std::uint8_t type = 0;  ///< 1 = u8, 10 = f32; others exist and no reader of ours wants them
    std::vector<std::uint64_t> shape;
    std::uint64_t offset = 0;
    std::uint64_t count = 0;  ///< product of shape
};

inline constexpr std::string_view kTensorMagic{"tensor_file\0", 12};
inline constexpr std::uint8_t kTensorU8 = 1, kTensorF32 = 10;

/// The directory of a file of the RGL container "tensor_file" 1.0. Throws
/// Error("malformed_measurement", "byte N: …"); every field lies within `bytes` afterwards.
std::map<std::string, TensorField> tensor_fields(std::string_view bytes);

/// A field of 32-bit floats as they are stored. Throws Error naming the field, or the byte of a
/// value that is no finite number.
std::vector<float> tensor_floats(std::string_view bytes, const std::string& name,
                                 const TensorField& field);

}  // namespace kiln::measured
