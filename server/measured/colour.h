// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <string>
#include <vector>

namespace kiln::measured {

/// How the channels of a file become red, green and blue: sums of them, so that it may come before
/// any interpolation.
struct Colouring {
    std::vector<std::array<double, 3>> weights;  ///< one a channel
    std::string words;                           ///< how an account names it

    /// Values of points, point-major in channels, become point-major in R, G and B.
    std::vector<float> seen(const std::vector<float>& values) const;
};

/// R, G and B as they are, X, Y and Z by a matrix, one channel three times. Wavelengths (names that
/// end in "nm") are seen by the observer of observer.h where lacks_for_colour() has nothing to say;
/// of others those nearest to 620, 540 and 460 nm stand for R, G and B, as they are. Throws
/// Error("unfit_measurement") for channels that are nothing of these.
Colouring colouring_of(const std::vector<std::string>& channels);

}  // namespace kiln::measured
