// SPDX-License-Identifier: Apache-2.0
#include "server/measured/mirror_azimuth.h"

#include <algorithm>
#include <cmath>

namespace kiln::measured {
namespace {

struct Peak {
    double theta_i = 0, azimuth = 0;
    bool distinct = false;
};

/// Where the points of the largest incidence up to 75 degrees are brightest, relative to their
/// phi_i; distinct if the lobe stands out three times over the median at its theta_o.
Peak find_peak(const Cloud& cloud) {
    Peak peak;
    for (std::size_t n = 0; n < cloud.size(); ++n)
        if (usable(cloud.state[n]) && cloud.theta_i[n] <= 75.0f)
            peak.theta_i = std::max(peak.theta_i, static_cast<double>(cloud.theta_i[n]));
    double most = -1;
    const std::size_t channels = cloud.channels.size();
    const auto brightness = [&](std::size_t n) {
        double sum = 0;
        for (std::size_t c = 0; c < channels; ++c) sum += cloud.at(n)[c];
        return sum;
    };
    const auto counts = [&](std::size_t n) {
        return usable(cloud.state[n]) && std::abs(cloud.theta_i[n] - peak.theta_i) < 1e-3;
    };
    std::size_t top = 0;
    for (std::size_t n = 0; n < cloud.size(); ++n)
        if (counts(n) && cloud.theta_o[n] > 10.0f && brightness(n) > most) {
            most = brightness(n);
            top = n;
        }
    if (most <= 0 || peak.theta_i < 10.0) return peak;
    peak.azimuth = wrapped_degrees(cloud.phi_o[top] - cloud.phi_i[top]);
    std::vector<double> ring;
    for (std::size_t n = 0; n < cloud.size(); ++n)
        if (counts(n) && std::abs(cloud.theta_o[n] - cloud.theta_o[top]) < 1e-3f)
            ring.push_back(brightness(n));
    if (ring.size() < 8) return peak;
    std::nth_element(ring.begin(), ring.begin() + static_cast<std::ptrdiff_t>(ring.size() / 2),
                     ring.end());
    peak.distinct = most > 3 * ring[ring.size() / 2];
    return peak;
}

}  // namespace

void settle_light_azimuth(Cloud& cloud, double usual, const ReadOptions& options,
                          Understood& account) {
    const Peak peak = find_peak(cloud);
    double azimuth = usual;
    std::string evidence = "the format's convention; the lobe is too flat to tell";
    if (peak.distinct) {
        const std::string place = "at the largest incidence, " + in_words(peak.theta_i) +
                                  " degrees, the brightest direction lies at azimuth " +
                                  in_words(peak.azimuth);
        const double off = wrapped_degrees(peak.azimuth - 180 - usual + 45);
        if (off > 90) {
            azimuth = wrapped_degrees(usual + 90 * std::floor(off / 90));
            account.warn(place + ", not near " + in_words(wrapped_degrees(usual + 180)) +
                         ": the light is taken to stand at " + in_words(azimuth));
        }
        evidence = place;
    }
    if (options.phi_in_deg) {
        azimuth = *options.phi_in_deg;
        evidence = "asked for";
    }
    account.found("azimuth", "light at " + in_words(azimuth) + " degrees", evidence);
    for (float& phi : cloud.phi_i) phi = static_cast<float>(wrapped_degrees(phi + azimuth));
}

}  // namespace kiln::measured
