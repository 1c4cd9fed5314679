// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>

#include "server/base/bound.h"

namespace kiln {

/// Values of a scene's JSON: what it takes in memory is at most some 200 times this many bytes.
inline constexpr std::size_t kSceneValuesMax = 1'500'000;
/// What one answer may list in detail.
inline constexpr std::size_t kSceneMaterialsMax = 4096;
inline constexpr std::size_t kSceneNameBytesMax = 256;
/// 4096²: a larger image is not looked into.
inline constexpr std::uint64_t kImageTexelsMax = 16'777'216;
/// Of all images together that a scene's numbers are read from.
inline constexpr std::uint64_t kSceneTexelsMax = 67'108'864;
/// Of the files of all images that a scene's numbers are read from: one that is told twice counts
/// twice.
inline constexpr std::uint64_t kSceneImageBytesMax = 67'108'864;
/// What decoding one image may allocate.
inline constexpr std::size_t kImageMemoryBytesMax = 134'217'728;
/// A progressive JPEG may repeat scans without end, each at the price of the whole image.
inline constexpr int kImageScansMax = 64;
/// Isolated roughnesses that get a row each; more become one range.
inline constexpr std::size_t kRowsMax = 8;

/// Bounds of this room that no setting moves.
Bounds scene_bounds();

}  // namespace kiln
