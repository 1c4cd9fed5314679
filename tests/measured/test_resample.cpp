// SPDX-License-Identifier: Apache-2.0
// The kernels' regular form against the triangulation that it is made of, and the bits of every
// backend.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <numbers>

#include "server/base/error.h"
#include "server/compute/measured_trial.h"
#include "server/compute/native.h"
#include "server/compute/opencl.h"
#include "server/measured/predicted_error.h"
#include "server/measured/resample.h"
#include "tests/compute/opencl_cache.h"
#include "tests/measured/files.h"
#include "tests/measured/synthetic.h"

namespace kiln {
namespace {

using namespace measured;

using measured_files::material_of;

const synthetic::Material kSatin = synthetic::ggx(0.35, {0.6, 0.5, 0.4}, {0.2, 0.2, 0.2});
const synthetic::Material kGlossy = synthetic::ggx(0.12, {0.6, 0.5, 0.4}, {0.2, 0.2, 0.2});

/// Measured every two degrees, which is what a test has time for.
std::string file_of(const synthetic::Material& surface) {
    synthetic::MiniDiffGrid grid;
    grid.azimuth_step = 2;
    grid.radial_step = 2.5;
    return synthetic::minidiff_file(surface, grid);
}

/// Views spread evenly by projected solid angle: the golden spiral on the disk.
std::vector<Vec> spiral(std::size_t count) {
    std::vector<Vec> out;
    for (std::size_t n = 0; n < count; ++n) {
        const double r2 = (static_cast<double>(n) + 0.5) / static_cast<double>(count);
        const double turn = static_cast<double>(n) * std::numbers::pi * (3 - std::sqrt(5.0));
        out.push_back(
            {std::sqrt(r2) * std::cos(turn), std::sqrt(r2) * std::sin(turn), std::sqrt(1 - r2)});
    }
    return out;
}

struct Difference {
    double relative = 0;  ///< sum of |kernel - triangulation| cos over the sum of the latter
    double origins = 0;   ///< share of views whose origin differs
};
Difference difference(const Material& material, const LobeTables& tables, double theta_in) {
    Resampler resampler;
    const std::vector<Vec> views = spiral(4000);
    const Sampled found = resampler.values(tables, theta_in, views);
    double off = 0, all = 0, origins = 0;
    for (std::size_t n = 0; n < views.size(); ++n) {
        Origin origin{};
        const Colour f = material.value(theta_in, views[n], origin);
        const float kernel[3] = {found.r[n], found.g[n], found.b[n]};
        for (std::size_t k = 0; k < 3; ++k) {
            off += std::abs(static_cast<double>(kernel[k]) - f[k]);
            all += std::abs(f[k]);
        }
        origins += found.origin[n] != static_cast<float>(origin);
    }
    return {off / all, origins / static_cast<double>(views.size())};
}

/// What the tables lose is below what the points leave open, as their report estimates it: cells
/// are half as wide as triangles, a quarter of the error.
TEST(Resample, TheKernelAgreesWithTheTriangulation) {
    for (const auto* surface : {&kSatin, &kGlossy}) {
        const Material material =
            material_of(file_of(*surface), {0.2, 0.3, ThetaInBeyond::reciprocity});
        const LobeTables tables = make_lobe_tables(material);
        double open = 0;
        for (std::size_t lobe = 0; lobe < 4; ++lobe) open += points_error(material, lobe) / 4;
        for (const double theta_in : {0.0, 20.0, 30.0, 60.0, 70.0, 80.0, 89.0}) {
            const Difference found = difference(material, tables, theta_in);
            EXPECT_LT(found.relative, 0.5 * open) << theta_in;
            // Between incidences the edge of what was measured has the width of a cell.
            const bool at_incidence = theta_in <= 60 && std::fmod(theta_in, 20) == 0;
            EXPECT_LT(found.origins, at_incidence ? 1e-3 : 0.02) << theta_in;
        }
    }
}

/// Midpoints over the triangulation's own values, rings of equal projected solid angle: the
/// integrand is f alone.
double midpoint_albedo(const Material& material, double theta_in) {
    const std::vector<Vec> views = spiral(40000);
    double sum = 0;
    for (const Vec& out : views) {
        Origin origin{};
        sum += std::max(0.0, material.value(theta_in, out, origin)[1]);
    }
    return sum * std::numbers::pi / static_cast<double>(views.size());
}

TEST(Resample, AlbedosAgreeWithASumOverTheTriangulation) {
    const Material material = material_of(file_of(kSatin), {0.2, 0.3, ThetaInBeyond::reciprocity});
    const LobeTables tables = make_lobe_tables(material);
    const std::vector<double> angles = {0, 20, 33, 60, 70, 80};
    const auto found = Resampler().albedos(tables, angles);
    // The spiral leaves 2e-4 of E to either side (tried at 4 and 16 times the points), 1e-3 where
    // the lobe leans on the horizon.
    for (std::size_t n = 0; n < angles.size(); ++n)
        EXPECT_NEAR(found[n].value[1] / midpoint_albedo(material, angles[n]), 1,
                    angles[n] > 60 ? 3e-3 : 6e-4)
            << angles[n];
}

/// Constant tables are integrated to rounding: the rule and its horizon alone are at work.
TEST(Resample, ALambertianHasItsAlbedoToRounding) {
    synthetic::MiniDiffGrid grid;
    grid.azimuth_step = grid.radial_step = 15;
    const Material material = material_of(
        synthetic::minidiff_file(synthetic::lambert({0.3, 0.5, 0.7}), grid), {1.0, 0.3, {}});
    const LobeTables tables = make_lobe_tables(material);
    const std::vector<double> angles = {0, 10, 45, 60, 75, 89, 90};
    const auto found = Resampler().albedos(tables, angles);
    for (std::size_t n = 0; n < angles.size(); ++n) {
        // Float sums of 256, and f with seven digits. Towards 90 degrees the horizon turns within
        // a spoke's width.
        const double relative = angles[n] <= 60 ? 1e-5 : 1e-4;
        EXPECT_NEAR(found[n].value[0], 0.3, 0.3 * relative) << angles[n];
        EXPECT_NEAR(found[n].value[1], 0.5, 0.5 * relative) << angles[n];
        EXPECT_NEAR(found[n].value[2], 0.7, 0.7 * relative) << angles[n];
    }
    EXPECT_NEAR(Resampler().average_albedo(tables).value[1], 0.5, 2e-5);
}

template <typename Scalar>
std::vector<Scalar> trial_values(Backend& backend, const MeasuredKind& what) {
    MeasuredTrial<Scalar> trial(what.operation);
    backend.run(trial.launch(what));
    return trial.values;
}

template <typename Scalar>
void expect_bits(Backend& backend, const std::vector<Scalar>& wanted, const MeasuredKind& what) {
    const auto found = trial_values<Scalar>(backend, what);
    ASSERT_EQ(found.size(), wanted.size());
    EXPECT_EQ(std::memcmp(found.data(), wanted.data(), wanted.size() * sizeof(Scalar)), 0)
        << static_cast<int>(what.operation);
}

template <typename Scalar>
void expect_native_bits(Precision precision) {
    ThreadPool one(1), three(3);
    for (const MeasuredOperation operation :
         {MeasuredOperation::values, MeasuredOperation::albedos}) {
        const MeasuredKind what{operation, precision};
        const auto sets = usable_instruction_sets();
        const auto wanted = trial_values<Scalar>(*make_native_backend(one, sets.front()), what);
        for (const Scalar value : wanted) ASSERT_TRUE(std::isfinite(value));
        for (const InstructionSet set : sets)
            for (ThreadPool* pool : {&one, &three})
                expect_bits(*make_native_backend(*pool, set), wanted, what);
    }
}

TEST(Resample, EveryInstructionSetGivesTheSameBits) {
    expect_native_bits<float>(Precision::float32);
    expect_native_bits<double>(Precision::float64);
}

/// On OpenCL the trial, and a slice of a material: the bits of native.
TEST(Resample, OpenClGivesTheBitsOfNative) {
    test::use_own_opencl_cache();
    ThreadPool pool(1);
    const auto native = make_native_backend(pool, usable_instruction_sets().front());
    std::unique_ptr<OpenClBackend> opencl;
    try {
        opencl = std::make_unique<OpenClBackend>(*native);
    } catch (const Error& error) {
        GTEST_SKIP() << error.what();
    }
    for (const MeasuredOperation operation :
         {MeasuredOperation::values, MeasuredOperation::albedos}) {
        const MeasuredKind what{operation, Precision::float32};
        opencl->build(what);
        EXPECT_EQ(opencl->numerics(what), kStrictNumerics);
        expect_bits(*opencl, trial_values<float>(*native, what), what);
    }
    synthetic::MiniDiffGrid grid;
    grid.azimuth_step = grid.radial_step = 5;
    const LobeTables tables =
        make_lobe_tables(material_of(synthetic::minidiff_file(kSatin, grid), {0.2, 0.3, {}}));
    const std::vector<Vec> views = spiral(1000);
    const Sampled a = Resampler(opencl.get()).values(tables, 35, views);
    const Sampled b = Resampler(native.get()).values(tables, 35, views);
    EXPECT_EQ(a.r, b.r);
    EXPECT_EQ(a.g, b.g);
    EXPECT_EQ(a.b, b.b);
    EXPECT_EQ(a.origin, b.origin);
    const std::vector<double> angles = {0, 35, 75};
    const auto x = Resampler(opencl.get()).albedos(tables, angles);
    const auto y = Resampler(native.get()).albedos(tables, angles);
    for (std::size_t n = 0; n < angles.size(); ++n) EXPECT_EQ(x[n].value, y[n].value);
    opencl.reset();
}

}  // namespace
}  // namespace kiln
