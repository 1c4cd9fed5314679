// SPDX-License-Identifier: Apache-2.0
#include "server/measured/colour.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "server/base/error.h"
#include "server/measured/observer.h"
#include "server/measured/reader.h"
#include "server/measured/text_scan.h"

namespace kiln::measured {
namespace {

/// Nanometres of a channel's name; NaN where it is none.
double nanometres(const std::string& name) {
    if (!name.ends_with("nm")) return NAN;
    const auto value = parse_number(trimmed(std::string_view(name).substr(0, name.size() - 2)));
    return value && *value > 0 ? *value : NAN;
}

Colouring nearest(const std::vector<double>& nm, const std::string& lack) {
    Colouring colouring{std::vector<std::array<double, 3>>(nm.size()), {}};
    std::string names;
    std::size_t k = 0;
    for (const double wanted : {620.0, 540.0, 460.0}) {
        const auto best = std::min_element(nm.begin(), nm.end(), [wanted](double a, double b) {
            return std::abs(a - wanted) < std::abs(b - wanted);
        });
        colouring.weights[static_cast<std::size_t>(best - nm.begin())][k] = 1;
        names += (k > 0 ? ", " : "") + in_words(*best);
        ++k;
    }
    colouring.words = names + " nm as red, green and blue, as they are: " + lack;
    return colouring;
}

Colouring spectral(const std::vector<double>& nm) {
    std::vector<std::size_t> order(nm.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(),
              [&](std::size_t a, std::size_t b) { return nm[a] < nm[b]; });
    std::vector<double> rising;
    for (const std::size_t n : order) rising.push_back(nm[n]);
    if (const std::string lack = lacks_for_colour(rising); !lack.empty()) return nearest(nm, lack);
    const auto weights = srgb_weights(rising);
    Colouring colouring{std::vector<std::array<double, 3>>(nm.size()), {}};
    for (std::size_t n = 0; n < order.size(); ++n) colouring.weights[order[n]] = weights[n];
    colouring.words = std::string(kObserverWords) + ", of " + std::to_string(nm.size()) +
                      " wavelengths from " + in_words(rising.front()) + " to " +
                      in_words(rising.back()) + " nm";
    return colouring;
}

}  // namespace

std::vector<float> Colouring::seen(const std::vector<float>& values) const {
    std::vector<float> result;
    result.reserve(values.size() / weights.size() * 3);
    for (std::size_t n = 0; n + weights.size() <= values.size(); n += weights.size())
        for (std::size_t k = 0; k < 3; ++k) {
            double sum = 0;
            for (std::size_t c = 0; c < weights.size(); ++c)
                // A channel of no weight may hold anything where the point does not count.
                if (weights[c][k] != 0) sum += weights[c][k] * static_cast<double>(values[n + c]);
            result.push_back(static_cast<float>(sum));
        }
    return result;
}

Colouring colouring_of(const std::vector<std::string>& channels) {
    // IEC 61966-2-1, CIE XYZ under D65 to linear sRGB.
    constexpr std::array<std::array<double, 3>, 3> kOfXyz = {
        {{3.2406, -0.9689, 0.0557}, {-1.5372, 1.8758, -0.2040}, {-0.4986, 0.0415, 1.0570}}};
    constexpr std::array<std::array<double, 3>, 3> kOfRgb = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    Colouring colouring{std::vector<std::array<double, 3>>(channels.size()), {}};
    const auto triple = [&](const std::array<const char*, 3>& names, const auto& matrix) {
        std::array<std::size_t, 3> at{};
        for (std::size_t k = 0; k < 3; ++k) {
            const auto found = std::find(channels.begin(), channels.end(), names[k]);
            if (found == channels.end()) return false;
            at[k] = static_cast<std::size_t>(found - channels.begin());
        }
        for (std::size_t k = 0; k < 3; ++k) colouring.weights[at[k]] = matrix[k];
        return true;
    };
    if (triple({"X", "Y", "Z"}, kOfXyz)) {
        colouring.words = "linear sRGB of X, Y and Z";
        return colouring;
    }
    if (triple({"R", "G", "B"}, kOfRgb)) {
        colouring.words = "red, green and blue of the file";
        return colouring;
    }
    std::vector<double> nm;
    for (const std::string& name : channels) nm.push_back(nanometres(name));
    const bool wavelengths = std::none_of(nm.begin(), nm.end(), [](double v) { return v != v; });
    if (wavelengths && nm.size() >= 3) return spectral(nm);
    if (channels.size() != 1)
        throw Error("unfit_measurement", "the channels of this file make no colour");
    colouring.weights[0] = {1, 1, 1};
    colouring.words = "one channel for all three";
    return colouring;
}

}  // namespace kiln::measured
