// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace kiln::test {

/// Of 64 times the digit.
inline std::string measurement(char digit) { return "sha256:" + std::string(64, digit); }

/// A binary glTF of a JSON text and a buffer.
std::string glb_of(std::string json, std::string binary);

/// RFC 4648.
std::string base64(std::string_view bytes);

/// PNG of `texels` (R G B A a texel, row-major), written by libpng.
std::string png_of(std::uint32_t width, std::uint32_t height,
                   const std::vector<unsigned char>& texels, bool interlaced = false);
/// The same as R G B JPEG at quality 100.
std::string jpeg_of(std::uint32_t width, std::uint32_t height,
                    const std::vector<unsigned char>& texels);

/// A scene of one triangle whose material has this JSON; `rest` are further members of the
/// document, each followed by a comma.
std::string scene_of(const std::string& material, const std::string& rest = "");

/// Sound scenes of every kind, for damage to start from.
std::vector<std::string> sound_scenes();

struct HostileScene {
    std::string name, bytes;
    std::string code;     ///< of the error that is due; "" where the scene is to be read
    std::string pointer;  ///< one of the places that it names
};
std::vector<HostileScene> hostile_scenes();

/// A copy of `bytes` damaged in a way that `seed` alone decides.
std::string mutated(const std::string& bytes, std::uint64_t seed);

}  // namespace kiln::test
