// SPDX-License-Identifier: Apache-2.0
#include "server/measured/observer.h"

#include <algorithm>
#include <cmath>

#include "server/measured/bounds.h"
#include "server/measured/reader.h"

namespace kiln::measured {
namespace {

/// A Gaussian with a width to each side of its middle, in nanometres, as Wyman, Sloan and Shirley
/// fitted them to colour matching functions (2013, "Simple Analytic Approximations to the CIE XYZ
/// Color Matching Functions").
struct Lobe {
    double amplitude, middle, below, above;
};

// Made by benchmarks/observer.py of the CIE's tables: the weights of R, G and B under D65. Colours
// of reflectances that rise within 40 nm are within 0.001 of those by the tables.
constexpr std::array<std::array<Lobe, 5>, 3> kWeights = {{
    {{{0.7656, 608.76, 13.81, 21.46},
      {0.2215, 440.29, 15.49, 14.31},
      {-0.6586, 521.5, 18.89, 17.91},
      {-0.3011, 484.84, 13.97, 81.63},
      {1.6604, 588.22, 20.23, 39.47}}},
    {{{0.9032, 532.32, 20.29, 30.51},
      {-0.3065, 447.54, 19.1, 20.04},
      {-0.2944, 592.58, 19.45, 36.72},
      {0.3565, 517.65, 41.87, 58.91},
      {0.4521, 574.26, 38.26, 20.51}}},
    {{{1.9082, 448.06, 17.71, 19.99},
      {0.3957, 467.05, 10.06, 23.92},
      {-0.0839, 523.53, 8.22, 50.86},
      {-0.0957, 551.02, 18.81, 32.87},
      {0.1094, 425.12, 5, 33.53}}},
}};

double weight(std::size_t channel, double nanometres) {
    double sum = 0;
    for (const Lobe& lobe : kWeights[channel]) {
        const double t =
            (nanometres - lobe.middle) / (nanometres < lobe.middle ? lobe.below : lobe.above);
        sum += lobe.amplitude * std::exp(-0.5 * t * t);
    }
    return sum;
}

}  // namespace

std::string lacks_for_colour(std::span<const double> nanometres) {
    const auto needs = [](const std::string& what) { return "; a colour needs " + what; };
    if (nanometres.empty() || nanometres.front() > kVisibleLow || nanometres.back() < kVisibleHigh)
        return "spectra from " + in_words(nanometres.empty() ? 0 : nanometres.front()) + " to " +
               in_words(nanometres.empty() ? 0 : nanometres.back()) + " nm" +
               needs(in_words(kVisibleLow) + " to " + in_words(kVisibleHigh) + " nm");
    for (std::size_t n = 1; n < nanometres.size(); ++n) {
        const double low = nanometres[n - 1], high = nanometres[n];
        if (low < kVisibleHigh && high > kVisibleLow &&
            high - low > static_cast<double>(kWavelengthStepMax))
            return "no spectrum between " + in_words(low) + " and " + in_words(high) + " nm" +
                   needs("steps of at most " + std::to_string(kWavelengthStepMax) + " nm");
    }
    return {};
}

std::vector<std::array<double, 3>> srgb_weights(std::span<const double> nanometres) {
    std::vector<std::array<double, 3>> weights(nanometres.size());
    std::array<double, 3> all{};
    for (double at = 360; at <= 830; at += 0.5) {
        const auto above = std::upper_bound(nanometres.begin(), nanometres.end(), at);
        const auto high =
            std::min(static_cast<std::size_t>(above - nanometres.begin()), nanometres.size() - 1);
        const std::size_t low = above == nanometres.begin() ? 0
                                : above == nanometres.end() ? high
                                                            : high - 1;
        const double share =
            low == high ? 0.0 : (at - nanometres[low]) / (nanometres[high] - nanometres[low]);
        for (std::size_t k = 0; k < 3; ++k) {
            const double w = weight(k, at);
            weights[low][k] += (1 - share) * w;
            weights[high][k] += share * w;
            all[k] += w;
        }
    }
    for (std::array<double, 3>& one : weights)
        for (std::size_t k = 0; k < 3; ++k) one[k] /= all[k];
    return weights;
}

}  // namespace kiln::measured
