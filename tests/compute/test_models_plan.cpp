// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>
#include <string>
#include <vector>

#include "server/compute/averages.h"
#include "server/compute/native.h"
#include "server/compute/unread.h"
#include "server/spec/words.h"
#include "tests/compute/models.h"

// What a job costs, and that slices of a three-dimensional table are the tables of two dimensions.
namespace kiln {
namespace {

using namespace models;

constexpr std::int64_t kFewSamples = 4096;

JobSpec few(std::vector<Quantity> quantities) {
    JobSpec job = model_job(std::move(quantities));
    job.sample_count = kFewSamples;
    return job;
}

bool leaves_out(const Outcome& outcome, const std::string& what) {
    const auto& list = outcome.report.left_out;
    return std::any_of(list.begin(), list.end(),
                       [&](const LeftOut& entry) { return entry.what == what; });
}

struct Cost {
    std::uint64_t brdf, fresnel, multiscatter;
    bool without_fresnel, without_multiscatter, without_diffuse;
};

/// In samples of all 8 texels; a line of one roughness has 2 places to an average's 8.
void costs(const JobSpec& job, const Cost& cost, const char* label) {
    const Outcome outcome = bake(job);
    const auto samples = static_cast<std::uint64_t>(kFewSamples);
    const Work& work = outcome.report.work;
    EXPECT_EQ(work.brdf_evaluations, cost.brdf * samples) << label;
    EXPECT_EQ(work.fresnel_evaluations, cost.fresnel * samples) << label;
    EXPECT_EQ(work.multiscatter_evaluations, cost.multiscatter * samples) << label;
    EXPECT_EQ(leaves_out(outcome, "Fresnel term"), cost.without_fresnel) << label;
    EXPECT_EQ(leaves_out(outcome, "multiple-scattering term"), cost.without_multiscatter) << label;
    EXPECT_EQ(leaves_out(outcome, "diffuse lobe"), cost.without_diffuse) << label;
}

TEST(Plan, WhatIsSetAndNotReadIsSaid) {
    using enum Quantity;
    JobSpec job;
    const auto unread = [&] {
        std::string all;
        for (const LeftOut& item : unread_fields(job)) all += item.what + ";";
        return all;
    };
    job.quantities = {split_sum_scale, split_sum_bias};
    EXPECT_EQ(unread(), "");
    job.fresnel.exponent = 7;  // A and B have that
    EXPECT_EQ(unread(), "");
    job.fresnel.f0 = {0.08};
    EXPECT_EQ(unread(), "f0 and f90;");
    job.quantities = {split_sum_scale, specular_albedo};  // which reads it
    EXPECT_EQ(unread(), "");
    job.quantities = {directional_albedo};
    job.fresnel.model = Fresnel::dielectric;
    EXPECT_EQ(unread(), "fresnel \"dielectric\";");
    job.seed = 5;
    job.sampler = Sampler::random;
    EXPECT_EQ(unread(), "fresnel \"dielectric\";");
    job.integrator = Integrator::quadrature;
    EXPECT_EQ(unread(), "fresnel \"dielectric\";sampler, seed;");

    JobSpec small = few({split_sum_scale});
    small.fresnel.f0 = {0.08};
    EXPECT_TRUE(leaves_out(bake(small), "f0 and f90"));
}

TEST(Plan, ATermThatIsNotAskedForCostsNothing) {
    using enum Quantity;
    JobSpec job = few({directional_albedo});
    job.fresnel.model = Fresnel::dielectric;
    job.diffuse.model = DiffuseModel::eon;
    job.multiscatter = Multiscatter::kulla_conty;
    job.coupling = Coupling::half_vector;
    costs(job, {8, 0, 0, true, true, true}, "directional_albedo");
    job.quantities = {average_albedo};
    costs(job, {2, 0, 0, true, true, true}, "average_albedo");
    job.quantities = {multiscatter_albedo};
    costs(job, {8, 0, 8, true, false, true}, "multiscatter_albedo");
    job.quantities = {specular_albedo};
    costs(job, {8, 8, 0, false, true, true}, "specular_albedo");
    job.quantities = {split_sum_scale, split_sum_bias};
    costs(job, {8, 8, 0, false, true, true}, "split sum");
    job.quantities = {compensated_albedo};
    costs(job, {8, 8, 8, false, false, true}, "compensated_albedo");
    job.multiscatter = Multiscatter::turquin;
    costs(job, {8, 8, 0, false, false, true}, "compensated_albedo by Turquin: E, no deficit");
    job.multiscatter = Multiscatter::kulla_conty;
    job.quantities = {diffuse_albedo};
    costs(job, {8, 0, 0, true, true, false}, "diffuse_albedo");
    job.quantities = {diffuse_average_albedo};
    costs(job, {2, 0, 0, true, true, false}, "diffuse_average_albedo");
    job.quantities = {fresnel_average};
    costs(job, {0, 0, 0, false, true, true}, "fresnel_average");
    // Both lobes, F of either, and the deficit.
    job.quantities = {total_albedo};
    costs(job, {16, 16, 8, false, false, false}, "total_albedo");
    job.coupling = Coupling::none;
    costs(job, {16, 8, 8, false, false, false}, "total_albedo, uncoupled");
    job.multiscatter = Multiscatter::none;
    costs(job, {16, 8, 0, false, true, false}, "total_albedo, single scattering");
    job.coupling = Coupling::view;
    costs(job, {16, 0, 0, false, true, false}, "total_albedo, F of the view alone");
    job.coupling = Coupling::kelemen;
    job.diffuse.model = DiffuseModel::lambert;
    costs(job, {8, 8, 0, false, true, false}, "total_albedo, matte lobe in closed form");
    job.coupling = Coupling::none;
    job.fresnel.model = Fresnel::none;
    costs(job, {16, 0, 0, true, true, false}, "total_albedo, F = 1");
    job.diffuse.model = DiffuseModel::ggx_lambert;
    costs(job, {16, 0, 0, true, true, false}, "total_albedo, walks");
    job.diffuse.model = DiffuseModel::none;
    costs(job, {8, 0, 0, true, true, true}, "total_albedo, specular alone");
}

TEST(Plan, ThreeChannelsCostThreeFresnelTermsAndOneLobe) {
    JobSpec job = few({Quantity::specular_albedo, Quantity::directional_albedo});
    job.fresnel.model = Fresnel::conductor;
    job.fresnel.metal = Metal::copper;
    costs(job, {8, 24, 0, false, true, true}, "three channels");
    // Schlick's three are combinations of the same two terms.
    job.fresnel = {};
    job.fresnel.f0 = {0.9, 0.6, 0.2};
    costs(job, {8, 8, 0, false, true, true}, "three channels of Schlick");
}

// A worker that says nothing for long is taken for hung, so averages over a line speak as they go.
TEST(Plan, AveragesSayThatTheyWork) {
    ThreadPool pool(1);
    const auto native = make_native_backend(pool, usable_instruction_sets().front());
    for (const Distribution distribution : {Distribution::ggx, Distribution::beckmann}) {
        JobSpec job = few({Quantity::compensated_albedo});
        job.distribution = distribution;
        int call_count = 0;
        Control control;
        control.progress = [&](const Progress&) { ++call_count; };
        const Averages averages = average_deficits(job, *native, pool, control);
        EXPECT_EQ(averages.deficit.size(), Places::averaged(job).count());
        EXPECT_GT(call_count, 1) << to_word(distribution);
    }
}

// The numbers of the warning beside Hoffman's formula, written out here.
TEST(Plan, WarnsOfANegativeReflectanceWithItsNumbers) {
    JobSpec job = few({Quantity::specular_albedo});
    job.fresnel.model = Fresnel::f82_tint;
    job.fresnel.f0 = {0.9, 0.6, 0.2};
    job.fresnel.f82 = {0.5, 0.8, 0};
    const auto F = [](double VoH) {
        const double schlick = .2 + .8 * std::pow(1 - VoH, 5), m = 1. / 7;
        const double at_82 = .2 + .8 * std::pow(6. / 7, 5);
        return schlick - at_82 / (m * std::pow(6. / 7, 6)) * VoH * std::pow(1 - VoH, 6);
    };
    double least = 1, at = 0;
    for (int i = 0; i <= 1000; ++i)
        if (F(i / 1e3) < least) least = F(i / 1e3), at = i / 1e3;
    ASSERT_LT(least, 0);
    std::ostringstream numbers;
    numbers << std::setprecision(3) << "least " << least << " at " << at;
    const auto warnings = bake(job).report.warnings;
    ASSERT_EQ(warnings.size(), 1U);
    EXPECT_NE(warnings[0].find("f0 0.2, f82 0:"), std::string::npos) << warnings[0];
    EXPECT_NE(warnings[0].find(numbers.str()), std::string::npos)
        << warnings[0] << " beside " << numbers.str();
    job.fresnel.f82 = {0.5, 0.8, 1};
    EXPECT_TRUE(bake(job).report.warnings.empty());
    job.fresnel.f82 = {0, 0, 0};
    job.quantities = {Quantity::directional_albedo};
    EXPECT_TRUE(bake(job).report.warnings.empty()) << "nothing reads the Fresnel term";
    // Along z the worst slice speaks for all.
    job.quantities = {Quantity::specular_albedo};
    job.fresnel.f0 = {0.04};
    job.fresnel.f82 = {0};
    job.resolution.push_back(8);
    job.axes.push_back(against_reference::axis(Parameter::f0));
    EXPECT_EQ(bake(job).report.warnings.size(), 1U);
}

/// Bits of slice z of every plane beside the two-dimensional job with that number.
void expect_slices(const JobSpec& solid, const std::vector<JobSpec>& flats) {
    const Outcome stack = bake(solid);
    const auto texels = static_cast<std::size_t>(solid.resolution[0] * solid.resolution[1]);
    ASSERT_EQ(stack.table.height,
              static_cast<std::size_t>(solid.resolution[1] * solid.resolution[2]));
    for (std::size_t z = 0; z < flats.size(); ++z) {
        const Outcome flat = bake(flats[z]);
        ASSERT_EQ(stack.table.channels, flat.table.channels);
        for (std::size_t channel = 0; channel < flat.table.planes.size(); ++channel)
            for (std::size_t i = 0; i < texels; ++i) {
                EXPECT_EQ(stack.table.planes[channel][z * texels + i],
                          flat.table.planes[channel][i])
                    << flat.table.channels[channel] << " slice " << z << " texel " << i;
                EXPECT_EQ(stack.standard_errors[channel][z * texels + i],
                          flat.standard_errors[channel][i])
                    << flat.table.channels[channel] << " slice " << z << " texel " << i;
            }
    }
}

// No kernel is without a term: what reflects nothing is 0, on every device.
TEST(Plan, WhatReflectsNothingIsBakedToo) {
    JobSpec job = few({Quantity::specular_albedo, Quantity::total_albedo});
    job.fresnel.f0 = job.fresnel.f90 = {0};
    job.diffuse.model = DiffuseModel::none;
    for (const Coupling coupling : {Coupling::none, Coupling::half_vector, Coupling::kelemen}) {
        job.coupling = coupling;
        const Outcome outcome = bake(job);
        for (const auto& plane : outcome.table.planes)
            for (const float value : plane) EXPECT_EQ(value, 0);
    }
}

// The third channel of engines' tables: a lobe beside the job's, at the same places.
TEST(Plan, SheenIsCharlieUnderNeubeltsMaskingWhateverTheLobe) {
    JobSpec cloth = few({Quantity::directional_albedo});
    cloth.distribution = Distribution::charlie;
    cloth.masking = Masking::neubelt;
    cloth.importance = Importance::uniform;
    const Outcome alone = bake(cloth);
    const Outcome beside = bake(few({Quantity::split_sum_bias, Quantity::directional_albedo,
                                     Quantity::sheen_albedo, Quantity::diffuse_albedo}));
    EXPECT_EQ(beside.table.planes[2], alone.table.planes[0]);
    EXPECT_NE(beside.table.planes[1], alone.table.planes[0]);
    EXPECT_EQ(beside.standard_errors[2], alone.standard_errors[0]);
}

// A grid of nodes has roughness 0, where Charlie's normals lie along the horizon.
TEST(Plan, CharlieOfNoWidthReflectsNothing) {
    JobSpec job = few({Quantity::directional_albedo});
    job.distribution = Distribution::charlie;
    job.importance = Importance::uniform;
    job.axes[1] = against_reference::axis(Parameter::roughness, Grid::node);
    for (const Masking masking : {Masking::neubelt, Masking::charlie}) {
        job.masking = masking;
        const Outcome outcome = bake(job);
        for (std::int64_t x = 0; x < job.resolution[0]; ++x)
            EXPECT_EQ(outcome.table.planes[0][static_cast<std::size_t>(x)], 0);
        EXPECT_GT(outcome.table.planes[0].back(), 0.1);
    }
    // Nothing comes back at once, and all of it in the end.
    JobSpec white = job;
    white.quantities = {Quantity::compensated_albedo};
    white.fresnel.model = Fresnel::none;
    white.multiscatter = Multiscatter::kulla_conty;
    EXPECT_EQ(bake(white).table.planes[0][0], 1);
    // A view along the horizon sees normals without bound.
    job.axes[0] = against_reference::axis(Parameter::NoV, Grid::node);
    EXPECT_THROW(bake(job), std::exception);
}

TEST(Plan, WhatIsNotSampledIsNotThereforeLeftOut) {
    JobSpec job = few({Quantity::compensated_albedo});
    job.multiscatter = Multiscatter::turquin;
    EXPECT_FALSE(leaves_out(bake(job), "multiple-scattering term"));
    job = few({Quantity::total_albedo});
    job.coupling = Coupling::kelemen;
    EXPECT_FALSE(leaves_out(bake(job), "diffuse lobe"));
    EXPECT_TRUE(leaves_out(bake(job), "sampling of the diffuse lobe"));
    job.coupling = Coupling::view;
    EXPECT_FALSE(leaves_out(bake(job), "Fresnel term"));
}

TEST(Plan, SlicesAlongF0AreTheTablesOfTwoDimensions) {
    JobSpec flat =
        few({Quantity::specular_albedo, Quantity::compensated_albedo, Quantity::fresnel_average,
             Quantity::total_albedo, Quantity::directional_albedo, Quantity::average_albedo});
    flat.multiscatter = Multiscatter::kulla_conty;
    flat.coupling = Coupling::half_vector;
    // From 4096 samples on, E alone has another sampler at low roughness than E beside 1 - E.
    flat.sample_count = kFewSamples / 4;
    JobSpec solid = flat;
    solid.resolution.push_back(3);
    solid.axes.push_back(against_reference::axis(Parameter::f0, Grid::node));
    std::vector<JobSpec> flats(3, flat);
    for (std::size_t z = 0; z < 3; ++z) flats[z].fresnel.f0 = {0.5 * static_cast<double>(z)};
    expect_slices(solid, flats);
}

TEST(Plan, SlicesAlongIorAreTheTablesOfTwoDimensions) {
    JobSpec flat = few({Quantity::specular_albedo, Quantity::fresnel_average});
    flat.fresnel.model = Fresnel::dielectric;
    JobSpec solid = flat;
    solid.resolution.push_back(2);
    Axis z = against_reference::axis(Parameter::ior);
    z.lo = 0.5, z.hi = 2.5;
    solid.axes.push_back(z);
    std::vector<JobSpec> flats(2, flat);
    flats[0].fresnel.ior = {1};
    flats[1].fresnel.ior = {2};
    expect_slices(solid, flats);
}

// Blender's generalised Schlick: f0 = min(t⁴, .99) at its nodes, which no mapping spells.
TEST(Plan, ListedSlicesAreTheTablesOfTwoDimensions) {
    const JobSpec flat = few({Quantity::specular_albedo, Quantity::fresnel_average});
    JobSpec solid = flat;
    solid.resolution.push_back(4);
    solid.axes.push_back(against_reference::axis(Parameter::f0));
    std::vector<JobSpec> flats(4, flat);
    for (std::size_t z = 0; z < 4; ++z) {
        const double t = static_cast<double>(z) / 3;
        solid.axes[2].values.push_back(std::min(t * t * t * t, 0.99));
        flats[z].fresnel.f0 = {solid.axes[2].values[z]};
    }
    expect_slices(solid, flats);
}

}  // namespace
}  // namespace kiln
