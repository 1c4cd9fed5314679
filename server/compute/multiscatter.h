// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace kiln {

/// Kulla, Conty 2017: what the compensation lobe reflects of the energy that is missing, from F_avg
/// and 1 − E_avg. The second bounce carries two Fresnel factors, so F_avg is squared; `linear` is
/// the form of older slides.
inline double multiscatter_fresnel(bool linear, double average, double deficit) {
    if (average == 1) return 1;  // also of a lobe that sends nothing up, where it is 0 / 0
    return average * (linear ? 1 : average) * (1 - deficit) / (1 - average * deficit);
}

/// Turquin 2019, eq. 16: what the single-scattering lobe is scaled by, from F at normal incidence
/// and E.
inline double turquin_scale(double F0, double E) { return 1 + F0 * (1 - E) / E; }

}  // namespace kiln
