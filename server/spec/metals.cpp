// SPDX-License-Identifier: Apache-2.0
#include "server/spec/metals.h"

#include <cstddef>

namespace kiln {
namespace {

// Derived by benchmarks/metals.py from spectra of n and k (refractiveindex.info, CC0), the CIE 1931
// 2° observer and D65: each pair has the metal's colour in its channel at normal incidence, and its
// average over the hemisphere. At every other angle the colour is within 0.01 (copper; the others
// 0.003). Gold's red alone lies beyond what any pair reflects: it has the pair at 700 nm, where
// gold reflects most.
constexpr MetalConstants kMetals[] = {
    {Metal::aluminium,
     {{1.50970, 0.98668, 0.60723}},
     {{7.67280, 6.55422, 5.35637}},
     {{0.9073, 0.9159, 0.9223}},
     "Rakic 1995"},
    {Metal::chromium,
     {{3.24316, 3.11909, 2.28666}},
     {{3.28627, 3.33682, 3.11714}},
     {{0.5496, 0.5560, 0.5542}},
     "Johnson and Christy 1974"},
    {Metal::copper,
     {{0.26700, 1.04698, 1.29918}},
     {{3.74698, 2.62865, 2.36498}},
     {{0.9317, 0.6227, 0.5223}},
     "Johnson and Christy 1972"},
    {Metal::gold,
     {{0.13100, 0.49181, 1.48280}},
     {{4.06240, 2.23993, 1.78064}},
     {{1.0376, 0.7284, 0.3646}},
     "Johnson and Christy 1972"},
    {Metal::iron,
     {{2.92237, 2.92076, 2.54638}},
     {{3.07724, 2.93743, 2.74996}},
     {{0.5297, 0.5132, 0.4942}},
     "Johnson and Christy 1974"},
    {Metal::nickel,
     {{2.05086, 1.90695, 1.73279}},
     {{4.21610, 3.57306, 2.89852}},
     {{0.6971, 0.6405, 0.5632}},
     "Johnson and Christy 1974"},
    {Metal::platinum,
     {{2.36757, 2.07801, 1.83590}},
     {{4.24976, 3.66984, 3.09767}},
     {{0.6779, 0.6377, 0.5836}},
     "Rakic et al. 1998"},
    {Metal::silver,
     {{0.05740, 0.05538, 0.04327}},
     {{4.52284, 3.56233, 2.59139}},
     {{0.9894, 0.9840, 0.9778}},
     "Johnson and Christy 1972"},
    {Metal::titanium,
     {{2.76338, 2.50812, 2.24318}},
     {{3.84967, 3.39757, 3.01598}},
     {{0.6186, 0.5794, 0.5425}},
     "Johnson and Christy 1974"},
    {Metal::tungsten,
     {{3.63821, 3.49499, 3.31498}},
     {{2.92365, 2.74747, 2.50548}},
     {{0.5159, 0.4963, 0.4674}},
     "Weaver et al. 1975"},
};

}  // namespace

const MetalConstants& metal_constants(Metal metal) {
    return kMetals[static_cast<std::size_t>(metal)];
}

}  // namespace kiln
