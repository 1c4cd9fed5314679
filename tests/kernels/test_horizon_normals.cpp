// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "server/compute/native.h"
#include "server/compute/points.h"
#include "server/compute/quadrature.h"
#include "tests/kernels/one_lane.h"

// Normals towards the horizon of an average's views (their density: test_samplers.cpp).
namespace {

constexpr double kAlphas[] = {1e-8, 1e-4, 1e-2, 0.3};

kiln::PointSet points(std::int64_t count) {
    return kiln::make_points(kiln::Sampler::sobol_owen, kiln::PointKind::horizon_normals, 5, count);
}

// A point's weight is all normals' density of tan θ, 2 α² t / (α² + t²)², over the mean of its own
// and three of the wide one's, and 2 NoV over the density of NoV = v⁴.
TEST(HorizonNormals, WeighByTheDensityOfBothHalves) {
    const kiln::PointSet set = points(512);
    for (const double alpha : kAlphas)
        for (std::size_t i = 0; i < set.values.size(); i += kiln::kPointScalars) {
            const double* point = &set.values[i];
            const double NoV = point[5], c = point[1], cos_phi = point[0] / std::sqrt(point[3]);
            const in_double::View view = in_double::ggx_view(NoV, alpha);
            const in_double::HorizonNormal sample = in_double::sample_horizon_normal(view, point);
            const double tangent = std::tan(std::asin(NoV) / 2);  // half way to the horizon
            const double beta = std::hypot(tangent, alpha);
            const double t = (point[4] == 1 ? alpha : beta) * std::sqrt(point[3]) / c;
            const double length = c * std::sqrt(1 + t * t);
            EXPECT_NEAR(std::sqrt(sample.h.hh) / length, 1, 1e-12);
            const double VoH = std::sqrt((1 - NoV) * (1 + NoV)) * t * c * cos_phi + NoV * c;
            EXPECT_NEAR(view.S * sample.h.VoH2 / 2, VoH, 1e-12 * length);
            const double own = 2 * alpha * alpha * t / std::pow(alpha * alpha + t * t, 2);
            const double wide = beta * t / std::pow(beta * beta + t * t, 1.5);
            const double of_view = 2 * NoV * 4 * std::pow(NoV, 0.75);
            const double expected = of_view * 4 * own / (own + 3 * wide);
            EXPECT_NEAR(sample.inverse_NoH * c / expected, 1, 1e-9) << alpha << ' ' << NoV;
        }
}

// 2^17 points are within 1 % where 16384 have a standard error of .8 % (StiffDeficit.AveragesHave-
// ItToo) that falls faster than their root: five standard errors and more.
TEST(HorizonNormals, HaveTheDeficitOfAverages) {
    kiln::ThreadPool pool(1);
    const auto native = kiln::make_native_backend(pool, kiln::usable_instruction_sets().front());
    const kiln::PointSet set = points(1 << 17);
    for (const int masking : {KILN_MASKING_SMITH_CORRELATED, KILN_MASKING_SMITH_SEPARABLE})
        for (const double alpha : {1e-4, 1e-2, 0.1}) {
            kiln::KernelMaterial lobe;
            lobe.masking = masking;
            const double truth =
                kiln::quadrature_averages(*native, kiln::quadrature_average_kind(lobe), {},
                                          std::array{alpha}, 1e-9, [] {})
                    .mean[0];
            const in_double::Integrand what = {masking, KILN_IMPORTANCE_HORIZON_NORMALS,
                                               KILN_TERM_DEFICIT};
            double sum = 0;
            for (std::size_t i = 0; i < set.values.size(); i += kiln::kPointScalars) {
                const double* point = &set.values[i];
                const in_double::View view = in_double::ggx_view(point[5], alpha);
                const auto sample = in_double::sample_horizon_normal(view, point);
                const in_double::Light light = in_double::ggx_mirror(view, sample.h, point[1]);
                sum += in_double::weigh(what, view, sample.h, light, 0, sample.inverse_NoH).deficit;
            }
            EXPECT_NEAR(sum / (1 << 17) / truth, 1, 0.01) << masking << ' ' << alpha;
        }
}

}  // namespace
