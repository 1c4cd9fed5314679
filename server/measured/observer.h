// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <span>
#include <string>
#include <vector>

namespace kiln::measured {

/// Nanometres that spectra have to cover to have a colour: what lies beyond weighs less than 0.3 %.
inline constexpr double kVisibleLow = 400, kVisibleHigh = 700;

/// Why no colour is made of a spectrum at these wavelengths, which rise, "" where one is: they have
/// to cover kVisibleLow to kVisibleHigh in steps of kWavelengthStepMax at most.
std::string lacks_for_colour(std::span<const double> nanometres);

/// What each of the spectrum's samples adds to linear R, G and B: the colour of a reflectance under
/// D65 as the CIE's observer of 1931 (2 degrees) sees it, in sRGB's primaries; a flat reflectance
/// of 1 is (1, 1, 1). Between the wavelengths, which rise, a spectrum is linear, beyond them
/// constant.
std::vector<std::array<double, 3>> srgb_weights(std::span<const double> nanometres);

/// How an account names that.
inline constexpr const char* kObserverWords = "linear sRGB of the CIE 1931 2 degree observer, D65";

}  // namespace kiln::measured
