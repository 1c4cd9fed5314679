// SPDX-License-Identifier: Apache-2.0
#include "server/measured/tensor_file.h"

#include <array>
#include <cmath>

#include "server/measured/bounds.h"
#include "server/measured/byte_scan.h"
#include "server/measured/reader.h"

namespace kiln::measured {
namespace {

/// Bytes of the types 1 to 11: u8 i8 u16 i16 u32 i32 u64 i64 f16 f32 f64.
constexpr std::array<std::uint64_t, 12> kTypeBytes = {0, 1, 1, 2, 2, 4, 4, 8, 8, 2, 4, 8};

TensorField read_field(std::string_view bytes, std::uint64_t& at, std::string& name) {
    const auto length = load<std::uint16_t>(bytes, at);
    if (length > kTensorNameBytesMax)
        fail_at_byte(at, "a name of " + std::to_string(length) + " bytes");
    at += 2;
    if (bytes.size() - at < length) fail_at_byte(at, "the file ends within a name");
    name = plain_text(bytes.substr(at, length));
    at += length;
    const auto dimensions = load<std::uint16_t>(bytes, at);
    if (dimensions > kTensorDimensionsMax)
        fail_at_byte(at, "a field of " + std::to_string(dimensions) + " dimensions");
    TensorField field;
    field.type = load<std::uint8_t>(bytes, at + 2);
    if (field.type == 0 || field.type >= kTypeBytes.size())
        fail_at_byte(at + 2, "type " + std::to_string(field.type) + " is unknown");
    field.offset = load<std::uint64_t>(bytes, at + 3);
    const std::uint64_t shape_at = at + 11;
    at = shape_at;
    field.count = 1;
    for (std::uint16_t d = 0; d < dimensions; ++d, at += 8) {
        const auto size = load<std::uint64_t>(bytes, at);
        // No field is larger than the file, so no product of sizes is either.
        if (size == 0 || size > bytes.size() || field.count > bytes.size() / size)
            fail_at_byte(at, "the field " + name + " is empty or larger than the file");
        field.count *= size;
        field.shape.push_back(size);
    }
    const std::uint64_t room = bytes.size() - std::min<std::uint64_t>(field.offset, bytes.size());
    if (field.count > room / kTypeBytes[field.type])
        fail_at_byte(shape_at - 8, "the field " + name + " ends beyond the file");
    return field;
}

}  // namespace

std::map<std::string, TensorField> tensor_fields(std::string_view bytes) {
    if (!bytes.starts_with(kTensorMagic)) fail_at_byte(0, "no tensor_file");
    const auto major = load<std::uint8_t>(bytes, 12), minor = load<std::uint8_t>(bytes, 13);
    if (major != 1 || minor != 0)
        fail_at_byte(
            12, "version " + std::to_string(major) + "." + std::to_string(minor) + ", 1.0 is read");
    const auto count = load<std::uint32_t>(bytes, 14);
    if (count > kTensorFieldsMax) fail_at_byte(14, std::to_string(count) + " fields");
    std::uint64_t at = 18;
    std::map<std::string, TensorField> fields;
    for (std::uint32_t n = 0; n < count; ++n) {
        const std::uint64_t start = at;
        std::string name;
        const TensorField field = read_field(bytes, at, name);
        if (!fields.emplace(name, field).second)
            fail_at_byte(start, "a second field of the name " + name);
    }
    return fields;
}

std::vector<float> tensor_floats(std::string_view bytes, const std::string& name,
                                 const TensorField& field) {
    if (field.type != kTensorF32)
        fail_at_byte(field.offset, "the field " + name + " is not of 32-bit floats");
    std::vector<float> values(field.count);
    std::memcpy(values.data(), bytes.data() + field.offset, values.size() * sizeof(float));
    for (std::size_t n = 0; n < values.size(); ++n)
        if (!std::isfinite(values[n]))
            fail_at_byte(field.offset + n * sizeof(float),
                         "a value of the field " + name + " is no finite number");
    return values;
}

}  // namespace kiln::measured
