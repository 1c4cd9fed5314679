// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cmath>
#include <numbers>
#include <vector>

#include "server/compute/measured_launch.h"

namespace kiln {

/// A small material that meets every branch of kernels/measured.h, for trials of a device: three
/// lobes that end at 70 degrees, all angles of light, views of the whole sphere.
template <typename Scalar>
struct MeasuredTrial {
    static constexpr unsigned kLobes = 3, kRings = 9, kSpokes = 13;
    static constexpr std::size_t kStride = 128, kBatch = 32;
    std::vector<Scalar> nodes, curves, places, points, values;
    std::vector<BatchRange> batches;

    explicit MeasuredTrial(MeasuredOperation operation) {
        const auto add = [](std::vector<Scalar>& to, double value) {
            to.push_back(static_cast<Scalar>(value));
        };
        for (unsigned n = 0; n < kLobes * kRings * kSpokes; ++n)
            for (unsigned k = 0; k < 4; ++k)
                add(nodes, k == 3 ? n % 2 : 0.3 + 0.25 * std::sin(0.7 * n + k) - 0.1 * k);
        add(curves, 0.2), add(curves, 0.3);
        for (std::size_t n = 0; n < kMeasuredCurve; ++n) add(curves, 1 + 0.01 * double(n));
        for (std::size_t n = 0; n < kMeasuredCurve; ++n) add(curves, 1 - 0.001 * double(n));
        constexpr double kThird = std::numbers::pi / 9;  // 0, 20 and 40 degrees
        for (unsigned n = 0; n < kLobes; ++n) add(curves, kThird * n);
        for (unsigned n = 0; n < kLobes; ++n) add(curves, std::cos(kThird * n));
        for (unsigned n = 0; n < kLobes; ++n) add(curves, std::sin(kThird * n));
        for (std::size_t n = 0; n < kLobes * kMeasuredEdges; ++n)
            add(curves, 1.22 + 0.01 * std::sin(0.1 * double(n)));
        fill_places();
        if (operation == MeasuredOperation::values) {
            values.resize(4 * kStride);
            return;
        }
        places.resize(3 * kStride);
        for (std::size_t n = 0; n < 2 * kBatch; ++n) {
            const double turn = 0.37 * double(n);
            add(points, (double(n) + 0.5) / (2 * kBatch)), add(points, std::cos(turn));
            add(points, std::sin(turn)), add(points, 0.05);
        }
        batches = {{0, kBatch}, {kBatch, kBatch}};
        values.resize(2 * 4 * kStride);
    }

    MeasuredLaunch<Scalar> launch(const MeasuredKind& what) {
        return {
            what,  {kLobes, kRings, kSpokes, 1, 1}, nodes, curves, kStride, places, points, batches,
            values};
    }

  private:
    void fill_places() {
        places.resize(6 * kStride);
        for (std::size_t n = 0; n < kStride; ++n) {
            const double theta = std::numbers::pi / 2 * double(n % 16) / 15;
            const double tilt = std::numbers::pi * double(n) / (kStride - 1),
                         turn = 2.4 * double(n);
            const double all[6] = {theta,
                                   std::cos(theta),
                                   std::sin(theta),
                                   std::sin(tilt) * std::cos(turn),
                                   std::sin(tilt) * std::sin(turn),
                                   std::cos(tilt)};
            for (std::size_t k = 0; k < 6; ++k)
                places[k * kStride + n] = static_cast<Scalar>(all[k]);
        }
    }
};

}  // namespace kiln
