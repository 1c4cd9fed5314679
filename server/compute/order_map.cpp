// SPDX-License-Identifier: Apache-2.0
#include "server/compute/order_map.h"

#include <algorithm>

#include "server/compute/lattice.h"

namespace kiln {

namespace {

/// For each index the two rungs of a ladder around it.
struct Around {
    std::vector<std::size_t> low, high;
    Around(const std::vector<std::int64_t>& rungs, std::int64_t count) {
        std::size_t next = 0;  // the first rung at or above i; the last one is count - 1
        for (std::int64_t i = 0; i < count; ++i) {
            if (rungs[next] < i) ++next;
            high.push_back(next);
            low.push_back(rungs[next] == i || next == 0 ? next : next - 1);
        }
    }
};

}  // namespace

OrderMap make_order_map(const JobSpec& job, const Places& places, const QuadratureKind& kind,
                        const QuadratureParameters& parameters,
                        const QuadratureTolerance& tolerance, Backend& backend) {
    constexpr double kGrowth = 2, kMargin = 4;
    const std::int64_t width = job.resolution[0], height = job.resolution[1];
    const auto columns = ladder(width, job.axes[0].flip, kGrowth);
    const auto rows = ladder(height, job.axes[1].flip, kGrowth);
    std::vector<double> NoV, alpha;
    for (const std::int64_t y : rows)
        for (const std::int64_t x : columns) {
            NoV.push_back(places.NoV(static_cast<std::size_t>(y * width + x)));
            alpha.push_back(places.alpha(static_cast<std::size_t>(y * width + x)));
        }
    QuadratureResult found =
        integrate_quadrature(backend, kind, {NoV, alpha, parameters, {}}, tolerance);
    const bool relative = tolerance.deficit_relative > 0;
    // Not within the tolerance at any order.
    std::vector<std::uint8_t> open(found.step.size());
    for (std::size_t i = 0; i < open.size(); ++i)
        open[i] = found.error[i] > tolerance.absolute * std::max(1.0, found.E[i]) ? 1 : 0;
    for (std::size_t i = 0; i < found.step.size(); ++i)
        if (found.step[i] > 0 &&
            found.error[i] <= tolerance.absolute * std::max(1.0, found.E[i]) / kMargin &&
            (!relative || found.deficit_error[i] <= tolerance.deficit_relative / kMargin))
            --found.step[i];
    OrderMap map;
    map.evaluations = found.evaluations;
    const Around x(columns, width), y(rows, height);
    // What the rungs need, spread along x first: the loops along y are then plain maxima.
    const auto w = static_cast<std::size_t>(width), h = static_cast<std::size_t>(height);
    std::vector<std::uint8_t> steps(rows.size() * w);
    std::vector<std::uint8_t> opens(rows.size() * w);
    std::vector<float> errors(rows.size() * w);
    for (std::size_t j = 0; j < rows.size(); ++j)
        for (std::size_t i = 0; i < w; ++i) {
            const std::size_t low = j * columns.size() + x.low[i],
                              high = j * columns.size() + x.high[i];
            opens[j * w + i] = std::max(open[low], open[high]);
            steps[j * w + i] = std::max(found.step[low], found.step[high]);
            errors[j * w + i] = std::max(found.error[low], found.error[high]);
        }
    map.step.resize(w * h);
    map.error.resize(w * h);
    for (std::size_t j = 0; j < h; ++j) {
        const std::size_t low = y.low[j] * w, high = y.high[j] * w;
        for (std::size_t i = 0; i < w; ++i)
            map.step[j * w + i] = std::max(steps[low + i], steps[high + i]);
        for (std::size_t i = 0; i < w; ++i)
            map.error[j * w + i] = std::max(errors[low + i], errors[high + i]);
        for (std::size_t i = 0; i < w; ++i)
            map.unsettled += std::max(opens[low + i], opens[high + i]);
    }
    return map;
}

}  // namespace kiln
