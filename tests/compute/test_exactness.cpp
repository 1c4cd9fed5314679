// SPDX-License-Identifier: Apache-2.0
// What reports say of exactness, and the advice that rests on it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>

#include "server/base/error.h"
#include "server/compute/advice.h"
#include "server/compute/lattice.h"
#include "server/compute/native.h"
#include "server/compute/quadrature.h"
#include "server/spec/layouts.h"
#include "server/spec/spec.h"
#include "tests/compute/against_reference.h"
#include "tests/reference/diffuse_models.h"

namespace kiln {
namespace {

Outcome bake(const std::string& rest) {
    return Engine({}).run(parse_job(R"({"device":"native",)" + rest + "}"), Control{});
}

struct True {
    double rms = 0, max = 0;
};

True difference(const std::vector<float>& plane, const std::vector<double>& truth) {
    True found;
    for (std::size_t i = 0; i < plane.size(); ++i) {
        const double off = std::abs(plane[i] - truth[i]);
        found.rms += off * off;
        found.max = std::max(found.max, off);
    }
    found.rms = std::sqrt(found.rms / static_cast<double>(plane.size()));
    return found;
}

std::vector<double> exact_E(std::size_t width, std::size_t height) {
    std::vector<double> NoV, alpha;
    for (std::size_t i = 0; i < width; ++i)
        NoV.push_back((static_cast<double>(i) + 0.5) / static_cast<double>(width));
    for (std::size_t i = 0; i < height; ++i) {
        const double r = (static_cast<double>(i) + 0.5) / static_cast<double>(height);
        alpha.push_back(r * r);
    }
    return reference::table(reference::Quantity::directional, reference::Masking::correlated, NoV,
                            alpha);
}

TEST(Exactness, OfASmallTableIsThatOfEveryTexel) {
    const Outcome outcome =
        bake(R"("quantities":["directional_albedo"],"resolution":[24,20],"sample_count":64)");
    const True truth = difference(outcome.table.planes[0], exact_E(24, 20));
    const ChannelError& error = outcome.report.error[0];
    EXPECT_EQ(error.reference_texels, 24 * 20);
    // Quadrature in float is off by 1e-6 at most.
    EXPECT_NEAR(error.reference_rms.value(), truth.rms, 1e-6);
    EXPECT_NEAR(error.reference_max.value(), truth.max, 1e-6);
    EXPECT_GT(truth.max, 1e-4);
    EXPECT_GT(outcome.report.run_time_s.reference, 0);
}

TEST(Exactness, OfALargeTableIsWeighedFromALattice) {
    const Outcome outcome =
        bake(R"("quantities":["directional_albedo"],"resolution":[120,90],"sample_count":16)");
    const True truth = difference(outcome.table.planes[0], exact_E(120, 90));
    const ChannelError& error = outcome.report.error[0];
    EXPECT_GT(error.reference_texels.value(), 300);
    EXPECT_LT(error.reference_texels.value(), 120 * 90 / 2);
    // Errors of neighbours hang together (they share points), so some hundred texels say little
    // less than all: the rms within a quarter, the largest not above and not far below.
    EXPECT_NEAR(error.reference_rms.value() / truth.rms, 1, 0.25);
    EXPECT_LE(error.reference_max.value(), truth.max + 1e-6);
    EXPECT_GE(error.reference_max.value(), truth.max / 2);
}

TEST(Exactness, TakesEveryTexelWhereTheSamplesCostFarMore) {
    const Outcome outcome =
        bake(R"("quantities":["directional_albedo"],"resolution":[72,72],"sample_count":65536)");
    EXPECT_EQ(outcome.report.error[0].reference_texels, 72 * 72);
}

TEST(Exactness, IsNullWithoutQuadratureAndReconstructionEstimated) {
    const std::string rest = R"(,"directional_albedo"],"resolution":[16,16],"sample_count":4096,)";
    const Outcome folded =
        bake(R"("quantities":["diffuse_albedo")" + rest + R"("diffuse":{"model":"chan2018"})");
    EXPECT_FALSE(folded.report.error[0].reference_max);
    EXPECT_FALSE(folded.report.error[0].reference_texels);
    EXPECT_TRUE(folded.report.error[0].reconstruction_max);
    EXPECT_TRUE(folded.report.error[1].reference_max);
    const auto& left_out = folded.report.left_out;
    EXPECT_TRUE(std::ranges::any_of(left_out, [](const LeftOut& item) {
        return item.what == "the reference of diffuse_albedo" &&
               item.why.find("chan2018") != std::string::npos;
    }));

    // Burley's lobe is a polynomial of degree 5 in 1 - NoV, steepest at NoV = 0: its second
    // difference there, 20 (1 - 1/16)^3 / 16^2 / 8 of the coefficient 0.46 at roughness 1.
    const Outcome burley =
        bake(R"("quantities":["diffuse_albedo")" + rest + R"("diffuse":{"model":"burley"})");
    JobSpec job;
    job.resolution = {16, 16};
    job.axes.resize(2);
    job.axes[0].parameter = Parameter::NoV;
    job.axes[1].parameter = Parameter::roughness;
    EXPECT_NEAR(estimated_reconstruction_max(job, burley.table.planes[0]), 0.0037, 0.0015);
    // Quadrature knows what a lookup at the rim misses too: there the corner's texel stands.
    const auto albedo = [](double NoV, double roughness) {
        return reference::diffuse_albedo({reference::DiffuseModel::burley, roughness, 1}, NoV);
    };
    EXPECT_NEAR(burley.report.error[0].reconstruction_max.value(),
                std::abs(albedo(1e-4, 1) - albedo(1.0 / 32, 31.0 / 32)), 1e-4);
}

/// Bilinear lookup of one plane at texture coordinates.
double lookup(const std::vector<float>& plane, const JobSpec& job, double u, double v) {
    const auto line = [&](double t, std::size_t axis) {
        const double n = static_cast<double>(job.resolution[axis]);
        return std::clamp(job.axes[axis].grid == Grid::center ? t * n - 0.5 : t * (n - 1), 0.0,
                          n - 1);
    };
    const double x = line(u, 0), y = line(v, 1);
    const auto width = static_cast<std::size_t>(job.resolution[0]);
    const auto at = [&](double i, double j) {
        return static_cast<double>(
            plane[static_cast<std::size_t>(j) * width + static_cast<std::size_t>(i)]);
    };
    const auto next = [&](double i, std::size_t axis) {
        return std::min(std::floor(i) + 1, static_cast<double>(job.resolution[axis] - 1));
    };
    const double x0 = std::floor(x), y0 = std::floor(y), x1 = next(x, 0), y1 = next(y, 1);
    const double upper = at(x0, y0) + (at(x1, y0) - at(x0, y0)) * (x - x0);
    const double lower = at(x0, y1) + (at(x1, y1) - at(x0, y1)) * (x - x0);
    return upper + (lower - upper) * (y - y0);
}

double coordinate(const Axis& axis, double value) {
    const auto mapped = [&](double v) {
        if (axis.mapping == Mapping::linear) return v;
        return axis.mapping == Mapping::sqrt ? std::sqrt(v) : v * v;
    };
    const double low = mapped(axis.lo);
    const double at = (mapped(value) - low) / (mapped(axis.hi) - low);
    return axis.flip ? 1 - at : at;
}

/// Largest error of lookups of E at places that have nothing to do with texels: crowded towards NoV
/// and roughness 0, and towards NoV = alpha, where E dips. Quadrature's E is within 1e-9 of
/// tests/reference (test_quadrature).
double worst_lookup(const std::vector<float>& plane, const JobSpec& job, int places = 12000) {
    double worst = 0;
    const auto look = [&](double NoV, double roughness) {
        const auto outside = [](const Axis& axis, double value) {
            return value < axis.lo || value > axis.hi;
        };
        if (NoV < 1e-4 || NoV > 1 || roughness < 1e-2 || outside(job.axes[0], NoV) ||
            outside(job.axes[1], roughness))
            return;
        const double E = quadrature_directional_albedo(NoV, roughness * roughness, job.masking);
        const double found =
            lookup(plane, job, coordinate(job.axes[0], NoV), coordinate(job.axes[1], roughness));
        worst = std::max(worst, std::abs(found - E));
    };
    for (int i = 0; i < places; ++i) {  // Roberts' additive recurrence in two dimensions
        const double u = std::fmod(0.5 + 0.7548776662466927 * i, 1);
        const double v = std::fmod(0.5 + 0.5698402909980532 * i, 1);
        const double roughness = i % 2 == 0 ? std::pow(10, -2 * v) : v;
        if (i % 3 == 0) look(u, roughness);
        if (i % 3 == 1) look(std::pow(10, -4 * u), roughness);
        if (i % 3 == 2) look(roughness * roughness * std::pow(10, 2 * u - 1), roughness);
    }
    return worst;
}

JobSpec table_of_E(const std::string& grid, const std::string& x, const std::string& y, int size) {
    const std::string side = std::to_string(size);
    const std::string axis = R"(","grid":")" + grid + R"(","mapping":")";
    return parse_job(R"({"quantities":["directional_albedo"],"integrator":"quadrature",)"
                     R"("device":"native","resolution":[)" +
                     side + "," + side + R"(],"layout":{"x":{"parameter":"NoV)" + axis + x +
                     R"("},"y":{"parameter":"roughness)" + axis + y + "\"}}}");
}

TEST(Reconstruction, IsWithinAFactorOfTwoOfTheTrueMaximum) {
    for (const char* x : {"linear", "sqrt"})
        for (const char* y : {"linear", "sqrt"})
            for (const char* grid : {"center", "node"})
                for (const int size : {24, 256}) {
                    const JobSpec spec = table_of_E(grid, x, y, size);
                    const Outcome outcome = Engine({}).run(spec, Control{});
                    const double truth = worst_lookup(outcome.table.planes[0], spec);
                    const double told = outcome.report.error[0].reconstruction_max.value();
                    EXPECT_LE(told, 2 * truth) << canonical(spec);
                    EXPECT_GE(told, truth / 2) << canonical(spec);
                }
}

TEST(Reconstruction, IsKnownInEveryProgramsLayout) {
    for (const LayoutPreset& preset : layout_presets()) {
        const Outcome outcome =
            bake(R"("quantities":["split_sum_scale","split_sum_bias"],)"
                 R"("microfacet":{"masking":"smith_correlated"},)"
                 R"("integrator":"quadrature","resolution":[32,32],"layout":")" +
                 preset.name + "\"");
        for (const ChannelError& error : outcome.report.error) {
            EXPECT_GT(error.reconstruction_max.value(), 1e-5) << preset.name;
            EXPECT_LT(error.reconstruction_max.value(), 0.3) << preset.name;
        }
    }
}

TEST(Reconstruction, IsZeroOfWhatIsConstantAndThatOfAStraightLineAlongZ) {
    const Outcome outcome =
        bake(R"("quantities":["fresnel_average"],"integrator":"quadrature","resolution":[4,4,5],)"
             R"("fresnel":{"model":"schlick"},"layout":{"x":{"parameter":"NoV"},)"
             R"("y":{"parameter":"roughness"},"z":{"parameter":"f0","grid":"node"}})");
    EXPECT_LT(outcome.report.error[0].reconstruction_max.value(), 1e-6);
}

// A list that says what a range says: the same table, and the same of it in the report and in
// advice, which look between its slices.
TEST(Reconstruction, OfListedSlicesIsThatOfTheRangeTheySpell) {
    const auto job = [](const std::string& z) {
        return R"("quantities":["specular_albedo"],"integrator":"quadrature","resolution":[8,8,16],)"
               R"("layout":{"x":{"parameter":"NoV"},"y":{"parameter":"roughness"},)"
               R"("z":{"parameter":"f0",)" +
               z + "}}";
    };
    std::string values;
    for (int i = 0; i < 16; ++i) values += (i ? "," : "") + std::to_string(i / 16.0);
    const Outcome ranged = bake(job(R"("grid":"node","range":[0,0.9375])"));
    const Outcome listed = bake(job(R"("values":[)" + values + "]"));
    EXPECT_EQ(listed.table.planes, ranged.table.planes);
    const ChannelError &here = listed.report.error[0], &there = ranged.report.error[0];
    EXPECT_NEAR(here.reference_max.value(), there.reference_max.value(), 1e-9);
    EXPECT_NEAR(here.reconstruction_max.value(), there.reconstruction_max.value(), 1e-9);
}

/// Rounded to 11 binary digits, as half holds values from 6e-5 on.
float as_half(float value) {
    int exponent = 0;
    std::frexp(value, &exponent);
    return static_cast<float>(
        std::ldexp(std::nearbyint(std::ldexp(value, 11 - exponent)), exponent - 11));
}

struct Wish {
    const char* job;
    double bound;
};

/// What was named is baked, rounded as its pixels are, and looked up.
double taken(const JobSpec& named) {
    Outcome outcome = Engine({}).run(named, Control{});
    for (float& value : outcome.table.planes[0]) {
        if (named.pixel == PixelType::half) value = as_half(value);
        if (named.pixel == PixelType::uint16) value = std::nearbyint(value * 65535) / 65535;
    }
    return worst_lookup(outcome.table.planes[0], named);
}

// Bounds on E of both maskings, axes free and a program's own, half and 16 bits: the table stays
// within its bound between texels too, at 12000 places each, and is no better than it must be: the
// next smaller size of either axis is beyond the bound.
TEST(Advice, HoldsWhenItIsTaken) {
    ThreadPool pool(0);
    const auto native = make_native_backend(pool, usable_instruction_sets().front());
    const Wish wishes[] = {
        {R"("resolution":[256,256])", 4e-2},
        {R"("resolution":[256,256])", 1e-2},
        {R"("resolution":[256,256])", 4e-3},
        {R"("resolution":[64,64],"output":{"format":"png","pixel":"uint16"})", 2e-2},
        {R"("resolution":[64,64],"microfacet":{"masking":"smith_separable"})", 2e-2},
        {R"("resolution":[64,64],"layout":"unity")", 4e-2},
        {R"("resolution":[32,32],"layout":{"x":{"parameter":"NoV","range":[0.1,1]},)"
         R"("y":{"parameter":"roughness","range":[0.3,1]}})",
         1e-3}};
    for (const Wish& wish : wishes) {
        const JobSpec job =
            parse_job(R"({"quantities":["directional_albedo"],)" + std::string(wish.job) + "}");
        const auto candidates = advise(job, wish.bound, *native, pool, Control{});
        ASSERT_FALSE(candidates.empty()) << wish.job;
        const Candidate& best = candidates[0];
        for (const Candidate& candidate : candidates) {
            EXPECT_LE(candidate.total(), wish.bound);
            EXPECT_GE(candidate.bytes, best.bytes);
        }
        const JobSpec named = parse_job(canonical(best.job));
        const double truth = taken(named);
        std::printf(
            "%s, %g: %lld x %lld texels, told %.3g, true %.3g\n", wish.job, wish.bound,
            static_cast<long long>(named.resolution[0]),
            static_cast<long long>(named.resolution.at(named.resolution.size() > 1 ? 1 : 0)),
            best.total(), truth);
        EXPECT_LE(truth, wish.bound) << wish.job;
        EXPECT_LE(truth, best.total()) << wish.job;
        // 1.05, parabolas, and what 12000 places miss of the largest error: seen to .79.
        EXPECT_GE(truth, 0.75 * best.reconstruction) << wish.job;
        for (const std::size_t axis : {0, 1}) {
            const auto* at = std::find(std::begin(kAdvisedSizes), std::end(kAdvisedSizes),
                                       named.resolution[axis]);
            if (at == std::begin(kAdvisedSizes)) continue;
            JobSpec smaller = named;
            smaller.resolution[axis] = at[-1];
            EXPECT_GT(taken(smaller) + best.quantisation, 0.9 * wish.bound) << wish.job << axis;
        }
    }
}

TEST(Advice, LeavesAProgramsAxesAndSaysWhereNothingHelps) {
    ThreadPool pool(0);
    const auto native = make_native_backend(pool, usable_instruction_sets().front());
    const JobSpec job = parse_job(R"({"quantities":["average_albedo"],"resolution":[64],)"
                                  R"("output":{"format":"png","pixel":"uint16"}})");
    for (const Candidate& candidate : advise(job, 1e-3, *native, pool, Control{}))
        EXPECT_EQ(candidate.job.pixel, PixelType::uint16);  // 8 bits are off by 2e-3 alone
    const JobSpec unreal =
        parse_job(R"({"quantities":["split_sum_scale","split_sum_bias"],"resolution":[64,64],)"
                  R"("layout":"unreal","microfacet":{"masking":"smith_correlated"}})");
    for (const Candidate& candidate : advise(unreal, 0.2, *native, pool, Control{}))
        EXPECT_EQ(candidate.job.axes, unreal.axes);
    JobSpec folded = job;
    folded.quantities = {Quantity::diffuse_average_albedo};
    folded.diffuse.model = DiffuseModel::chan2018;
    EXPECT_THROW(advise(folded, 0.1, *native, pool, Control{}), Error);
    JobSpec coarse = unreal;
    coarse.format = ImageFormat::png;
    EXPECT_TRUE(advise(coarse, 5e-6, *native, pool, Control{}).empty());
}

}  // namespace
}  // namespace kiln
