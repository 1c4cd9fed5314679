// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdio>

#include "server/spec/words.h"
#include "server/study/convergence.h"

namespace kiln::convergence {

namespace {

constexpr DeviceChoice kDevices[] = {DeviceChoice::native, DeviceChoice::opencl};

std::string name_of(DeviceChoice device) {
    return device == DeviceChoice::opencl ? "OpenCL" : "native";
}

std::string name_of(const Recipe& recipe) {
    return std::string(to_word(recipe.sampler)) + ", " + std::string(to_word(recipe.importance)) +
           ", " + name_of(recipe.device);
}

/// The exponent p of error ~ samples^p by least squares.
double order_of(const std::vector<Measured>& points) {
    double n = 0, x = 0, y = 0, xx = 0, xy = 0;
    for (const Measured& point : points) {
        if (point.error_rms <= 0) continue;
        const double a = std::log(static_cast<double>(point.sample_count)),
                     b = std::log(point.error_rms);
        n += 1, x += a, y += b, xx += a * a, xy += a * b;
    }
    return (n * xy - x * y) / (n * xx - x * x);
}

using Figure = double Measured::*;

Series over_time(const std::string& name, const std::vector<Measured>& points, Figure figure) {
    Series series{name, {}, {}, {}, {}};
    for (const Measured& point : points) {
        series.x.push_back(point.median());
        series.y.push_back(point.*figure);
        series.low.push_back(point.least());
        series.high.push_back(point.most());
    }
    return series;
}

LineChart error_over_time(const Curves& curves, const std::string& title, Figure figure) {
    LineChart chart{title, "seconds of integration", "error", true, true, {}};
    const auto add = [&](const Recipe& recipe) {
        const auto at = curves.sampled.find(recipe);
        if (at != curves.sampled.end())
            chart.series.push_back(over_time(name_of(recipe), at->second, figure));
    };
    for (const DeviceChoice device : kDevices) add({device, Sampler::sobol_owen, Importance::vndf});
    for (const DeviceChoice device : kDevices) {
        if (!curves.quadrature.contains(device)) continue;
        add({device, Sampler::random, Importance::vndf});
        add({device, Sampler::hammersley, Importance::ndf});
        break;
    }
    for (const DeviceChoice device : kDevices)
        if (const auto at = curves.quadrature.find(device); at != curves.quadrature.end())
            chart.series.push_back(over_time("quadrature, " + name_of(device), at->second, figure));
    return chart;
}

/// Curves of the recipes that `matches`, named by `name`, with their fitted order.
template <class Matches, class Name>
LineChart error_over_samples(const Curves& curves, const std::string& title, Matches matches,
                             Name name) {
    LineChart chart{title, "samples a texel", "rms error", true, true, {}};
    for (const auto& [recipe, points] : curves.sampled) {
        if (recipe.device != curves.sampled.begin()->first.device || !matches(recipe)) continue;
        char label[96];
        std::snprintf(label, sizeof label, "%s, order %.2f", std::string(name(recipe)).c_str(),
                      order_of(points));
        Series series{label, {}, {}, {}, {}};
        for (const Measured& point : points) {
            series.x.push_back(static_cast<double>(point.sample_count));
            series.y.push_back(point.error_rms);
        }
        chart.series.push_back(std::move(series));
    }
    return chart;
}

}  // namespace

std::vector<Chart> charts_of(const Curves& curves) {
    const Importance importance = curves.sampled.begin()->first.importance;
    return {error_over_time(curves, "Error against run time, rms", &Measured::error_rms),
            error_over_time(curves, "Error against run time, largest", &Measured::error_max),
            error_over_samples(
                curves, "Samplers under " + std::string(to_word(importance)),
                [&](const Recipe& r) { return r.importance == importance; },
                [](const Recipe& r) { return to_word(r.sampler); }),
            error_over_samples(
                curves, "Importances with sobol_owen",
                [](const Recipe& r) { return r.sampler == Sampler::sobol_owen; },
                [](const Recipe& r) { return to_word(r.importance); })};
}

}  // namespace kiln::convergence
