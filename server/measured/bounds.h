// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>

#include "server/base/bound.h"

namespace kiln::measured {

/// A MERL table of 360 azimuths has 69 984 012 bytes. What an upload may have is a setting.
inline constexpr std::size_t kFileBytesMax = std::size_t{72} << 20;
/// The same table has 2 916 000 cells.
inline constexpr std::size_t kPointsMax = std::size_t{4} << 20;
inline constexpr std::size_t kChannelsMax = 64;
/// Points times channels of all components of a file: 64 MiB of floats.
inline constexpr std::size_t kValuesMax = std::size_t{16} << 20;
inline constexpr std::size_t kLineBytesMax = std::size_t{1} << 20;
/// Documents that are parsed as a whole, where a byte may become 30 bytes of tree.
inline constexpr std::size_t kDocumentBytesMax = std::size_t{8} << 20;
inline constexpr std::size_t kXmlTagsMax = 200000;
inline constexpr std::size_t kComponentsMax = 64;
/// Of findings, warnings and things left out, so that a hostile file cannot make a long account.
inline constexpr std::size_t kRemarksMax = 64;
/// Angles of one axis, and blocks of values, of a text file.
inline constexpr std::size_t kAxisAnglesMax = 4096;
inline constexpr std::size_t kBlocksMax = 4096;
inline constexpr std::size_t kPatchesMax = 2048;     ///< of an angle basis in XML
inline constexpr std::size_t kPrefaceLinesMax = 32;  ///< before a line of names
inline constexpr std::size_t kTensorFieldsMax = 64, kTensorNameBytesMax = 64;
inline constexpr std::size_t kTensorDimensionsMax = 8;
/// Nanometres: wider than this, an edge of a spectrum has no place.
inline constexpr std::size_t kWavelengthStepMax = 25;
/// Directions of light in one component, and those that an account lists.
inline constexpr std::size_t kIncidencesMax = 2048;
inline constexpr std::size_t kSurveyedIncidencesMax = 160;

/// Of the measured room.
Bounds measured_bounds();

}  // namespace kiln::measured
