// SPDX-License-Identifier: Apache-2.0
// Where each preset puts its texels, and what lies there.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "server/compute/axes.h"
#include "server/spec/layouts.h"
#include "server/spec/spec.h"
#include "tests/compute/against_reference.h"

namespace kiln {
namespace {

using namespace against_reference;

using Formula = std::function<double(double i, double n)>;

/// Row 0 is the first line of the image.
struct Convention {
    const char* name;
    Parameter x;  ///< the other axis carries the other of NoV and roughness
    Formula x_at, y_at;
    Masking masking;
    std::vector<Quantity> quantities;
};

std::vector<Convention> conventions() {
    using enum Quantity;
    const Formula centre = [](double i, double n) { return (i + .5) / n; };
    const Formula node = [](double i, double n) { return i / (n - 1); };
    const Formula node_of_root = [](double i, double n) { return std::pow(i / (n - 1), 2); };
    const Formula high = [](double i, double n) { return std::min((n - i + .5) / n, 1.); };
    const Formula unbounded = [](double i, double n) { return (n - i + .5) / n; };
    const Formula floored = [](double i, double n) { return std::max(i / (n - 1), 1e-4); };
    const auto NoV = Parameter::NoV, roughness = Parameter::roughness;
    const auto smith = Masking::smith_correlated;
    return {
        {"kiln", NoV, centre, centre, smith, {split_sum_scale, split_sum_bias}},
        {"unreal", NoV, centre, centre, Masking::unreal_joint, {split_sum_scale, split_sum_bias}},
        {"unity", NoV, node_of_root, node, smith, {split_sum_bias, directional_albedo}},
        {"filament", NoV, centre, high, smith, {split_sum_bias, directional_albedo}},
        {"godot", NoV, centre, unbounded, Masking::karis_ibl, {split_sum_bias, directional_albedo}},
        {"threejs", roughness, centre, centre, smith, {split_sum_scale, split_sum_bias}},
        {"babylon", NoV, centre, centre, smith, {split_sum_bias, directional_albedo}},
        {"cycles", roughness, floored, floored, smith, {directional_albedo}},
        {"gltf", NoV, centre, centre, smith, {split_sum_scale, split_sum_bias}}};
}

JobSpec job_of(const Convention& convention, std::int64_t width, std::int64_t height) {
    JobSpec job = parse_job(R"({"quantities":["directional_albedo"],"layout":")" +
                            std::string(convention.name) + "\"}");
    job.quantities = convention.quantities;
    job.resolution = {width, height};
    job.device = DeviceChoice::native;
    return job;
}

TEST(Layouts, TexelsLieWhereThePublishedFormulasSay) {
    ASSERT_EQ(conventions().size(), layout_presets().size());
    for (const Convention& c : conventions()) {
        SCOPED_TRACE(c.name);
        const JobSpec job = job_of(c, 31, 64);
        EXPECT_EQ(job.masking, c.masking);
        EXPECT_EQ(job.axes[0].parameter, c.x);
        for (std::int64_t i = 0; i < 31; ++i)
            EXPECT_NEAR(axis_value(job.axes[0], i, 31), c.x_at(static_cast<double>(i), 31), 1e-15);
        for (std::int64_t i = 0; i < 64; ++i)
            EXPECT_NEAR(axis_value(job.axes[1], i, 64), c.y_at(static_cast<double>(i), 64), 1e-15);
    }
    const auto row_0 = [](const char* name) {
        return axis_value(layout_preset(name)->axes[1], 0, 128);
    };
    EXPECT_EQ(row_0("filament"), 1);
    EXPECT_EQ(row_0("godot"), 1.00390625);
}

// The recommended recipe's accuracy: see test_accuracy.cpp.
TEST(Layouts, TablesAreExactAtThosePlaces) {
    constexpr std::int64_t kWidth = 15, kHeight = 16;
    for (const Convention& c : conventions()) {
        if (c.masking != Masking::smith_correlated) continue;  // the reference has Smith alone
        SCOPED_TRACE(c.name);
        JobSpec job = job_of(c, kWidth, kHeight);
        job.sample_count = 4096;
        const Outcome outcome = bake(job);
        const bool NoV_on_x = c.x == Parameter::NoV;
        Values x, y;
        for (int i = 0; i < kWidth; ++i) x.push_back(c.x_at(i, kWidth));
        for (int i = 0; i < kHeight; ++i) y.push_back(c.y_at(i, kHeight));
        Values NoV = NoV_on_x ? x : y, alpha = NoV_on_x ? y : x;
        for (double& r : alpha) r *= r;
        for (std::size_t channel = 0; channel < c.quantities.size(); ++channel) {
            const Values rows = reference::table(reference_of(c.quantities[channel]),
                                                 reference::Masking::correlated, NoV, alpha);
            for (std::size_t i = 0; i < rows.size(); ++i) {
                const std::size_t column = i % NoV.size(), row = i / NoV.size();
                const std::size_t texel = NoV_on_x ? i : column * alpha.size() + row;
                ASSERT_NEAR(outcome.table.planes[channel][texel], rows[i], 2e-3)
                    << "NoV " << NoV[column] << " alpha " << alpha[row];
            }
        }
    }
}

/// B and E of ggx under Schlick's G1 with k = alpha / 2 for every alpha > 0, by the midpoint rule
/// over half-vectors: tan² = alpha² u / (1 − u), so that D NoH dω = du dφ / 2π. u = 1 − (1 − s)²
/// takes the root out of 1 / NoH at the horizon. Good to 1e-4 (halving the step shows it).
reference::SplitSum karis_albedo(double NoV, double alpha, int steps) {
    const double sinV = std::sqrt(1 - NoV * NoV), k = alpha / 2;
    const auto G1 = [k](double cosine) { return cosine / (cosine * (1 - k) + k); };
    double E = 0, B = 0;
    for (int i = 0; i < steps; ++i) {
        const double s = (i + .5) / steps, u = 1 - (1 - s) * (1 - s);
        const double NoH = std::sqrt((1 - u) / (1 + (alpha * alpha - 1) * u));
        const double sinH = std::sqrt(1 - NoH * NoH);
        for (int j = 0; j < steps; ++j) {
            const double phi = std::numbers::pi * (j + .5) / steps;
            const double VoH = sinV * sinH * std::cos(phi) + NoV * NoH;
            const double NoL = 2 * VoH * NoH - NoV;
            if (VoH <= 0 || NoL <= 0) continue;
            const double weight =
                2 * (1 - s) * G1(NoV) * G1(NoL) * VoH / (NoV * NoH) / steps / steps;
            E += weight;
            B += weight * std::pow(1 - VoH, 5);
        }
    }
    return {E - B, B};
}

TEST(Layouts, GodotsRowBeyondRoughnessOneIsExactToo) {
    const Convention godot = conventions()[4];
    ASSERT_STREQ(godot.name, "godot");
    JobSpec job = job_of(godot, 4, 4);  // roughness 1.125, .875, .625, .375
    job.sample_count = 1 << 16;
    const Outcome outcome = bake(job);
    for (std::size_t i = 0; i < 16; ++i) {
        const double NoV = (static_cast<double>(i % 4) + .5) / 4;
        const double r = (4 - static_cast<double>(i / 4) + .5) / 4;
        const reference::SplitSum truth = karis_albedo(NoV, r * r, 800);
        const reference::SplitSum coarse = karis_albedo(NoV, r * r, 400);
        ASSERT_NEAR(truth.scale + truth.bias, coarse.scale + coarse.bias, 1e-4);
        EXPECT_NEAR(outcome.table.planes[0][i], truth.bias, 3e-4) << NoV << ' ' << r;
        EXPECT_NEAR(outcome.table.planes[1][i], truth.scale + truth.bias, 3e-4) << NoV << ' ' << r;
    }
    EXPECT_TRUE(outcome.report.warnings.empty());
    job.masking = Masking::smith_correlated;
    EXPECT_EQ(bake(job).report.warnings, layout_warnings(job));
}

}  // namespace
}  // namespace kiln
