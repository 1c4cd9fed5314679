// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <functional>
#include <string>
#include <vector>

#include "server/spec/metals.h"
#include "server/spec/words.h"
#include "tests/compute/models.h"

// The Fresnel models over GGX, one channel or three, and what multiple scattering makes of them.
namespace kiln {
namespace {

using namespace models;

struct FresnelCase {
    std::string name;
    FresnelModel model;
    std::vector<reference::Fresnel> channels;  ///< one or three
};

FresnelModel model_of(Fresnel model) {
    FresnelModel made;
    made.model = model;
    return made;
}

FresnelCase schlick(std::vector<double> f0, double f90, double exponent) {
    FresnelCase made{"schlick", model_of(Fresnel::schlick), {}};
    for (const double one : f0)
        made.channels.push_back(reference::fresnel_schlick(one, f90, exponent));
    made.model.f0 = std::move(f0);
    made.model.f90 = {f90};
    made.model.exponent = exponent;
    return made;
}

FresnelCase dielectric(std::vector<double> ior) {
    FresnelCase made{"dielectric", model_of(Fresnel::dielectric), {}};
    for (const double one : ior) made.channels.push_back(reference::fresnel_dielectric(one));
    made.model.ior = std::move(ior);
    return made;
}

FresnelCase conductor() {
    FresnelCase made{"conductor", model_of(Fresnel::conductor), {}};
    made.model.eta = {0.2, 0.9, 1.5};
    made.model.k = {3.9, 2.4, 1.9};
    for (std::size_t c = 0; c < 3; ++c)
        made.channels.push_back(reference::fresnel_conductor(made.model.eta[c], made.model.k[c]));
    return made;
}

FresnelCase gold() {
    FresnelCase made{"gold", model_of(Fresnel::conductor), {}};
    made.model.metal = Metal::gold;
    const MetalConstants& constants = metal_constants(Metal::gold);
    for (std::size_t c = 0; c < 3; ++c)
        made.channels.push_back(reference::fresnel_conductor(constants.eta[c], constants.k[c]));
    return made;
}

FresnelCase edge_tint() {
    FresnelCase made{"edge_tint", model_of(Fresnel::edge_tint), {}};
    made.model.reflectivity = {0.95, 0.64, 0.37};
    made.model.edge_tint = {0.9, 0.5, 0.1};
    for (std::size_t c = 0; c < 3; ++c)
        made.channels.push_back(
            reference::fresnel_edge_tint(made.model.reflectivity[c], made.model.edge_tint[c]));
    return made;
}

FresnelCase f82_tint() {
    FresnelCase made{"f82_tint", model_of(Fresnel::f82_tint), {}};
    made.model.f0 = {0.9, 0.6, 0.2};
    made.model.f82 = {0.5, 0.8, 1};
    for (std::size_t c = 0; c < 3; ++c)
        made.channels.push_back(reference::fresnel_f82_tint(made.model.f0[c], made.model.f82[c]));
    return made;
}

std::vector<FresnelCase> every_fresnel() {
    return {{"none", model_of(Fresnel::none), {reference::fresnel_none()}},
            schlick({0.04}, 1, 5),
            schlick({0.9, 0.6, 0.2}, 0.95, 3.5),
            dielectric({1.5}),
            dielectric({1 / 1.5}),
            dielectric({1.33, 1.5, 2.4}),
            conductor(),
            gold(),
            edge_tint(),
            f82_tint()};
}

struct MultiscatterCase {
    Multiscatter ours;
    reference::Multiscatter theirs;
    FresnelCase fresnel;
    std::string name;
};

std::vector<MultiscatterCase> every_multiscatter() {
    return {
        {Multiscatter::none, reference::Multiscatter::none, f82_tint(), "none"},
        {Multiscatter::kulla_conty, reference::Multiscatter::kulla_conty, conductor(),
         "kulla_conty"},
        {Multiscatter::kulla_conty_linear, reference::Multiscatter::kulla_conty_first_power,
         schlick({0.3}, 1, 5), "kulla_conty_linear"},
        {Multiscatter::turquin, reference::Multiscatter::turquin, f82_tint(), "turquin"},
        {Multiscatter::turquin, reference::Multiscatter::turquin, dielectric({1.5}), "turquin"},
    };
}

reference::Microfacet ggx(double roughness) {
    return {reference::Distribution::ggx, reference::Visibility::smith_correlated,
            roughness * roughness};
}

TEST(Models, EveryFresnelModelOfTheContractIsACase) {
    for (std::size_t i = 0; i < words<Fresnel>().size(); ++i) {
        const auto cases = every_fresnel();
        EXPECT_TRUE(std::any_of(cases.begin(), cases.end(), [&](const FresnelCase& one) {
            return one.model.model == static_cast<Fresnel>(i);
        })) << words<Fresnel>()[i];
    }
    const auto cases = every_multiscatter();
    for (std::size_t i = 0; i < words<Multiscatter>().size(); ++i)
        EXPECT_TRUE(std::any_of(cases.begin(), cases.end(), [&](const MultiscatterCase& one) {
            return one.ours == static_cast<Multiscatter>(i);
        })) << words<Multiscatter>()[i];
}

// Exponents below 1 are steep without end where VoH = 1: a cosine that is off by one rounding there
// makes .2 of the 0 that (1 - VoH)^.1 is.
TEST(Models, AMirrorHasTheFresnelTermOfItsView) {
    std::vector<FresnelCase> cases = every_fresnel();
    cases.push_back(schlick({0.04}, 1, 0.1));
    for (const FresnelCase& fresnel : cases) {
        JobSpec job = model_job({Quantity::specular_albedo});
        job.resolution = {3, 1};
        job.axes[0].grid = Grid::node;
        job.axes[0].lo = 0.5;
        job.axes[1].lo = job.axes[1].hi = 0;
        job.fresnel = fresnel.model;
        job.sample_count = 64;
        const Outcome outcome = bake(job);
        for (std::size_t c = 0; c < fresnel.channels.size(); ++c)
            for (std::size_t i = 0; i < 3; ++i) {
                const double NoV = 0.5 + 0.25 * static_cast<double>(i);
                EXPECT_NEAR(outcome.table.planes[c][i], fresnel.channels[c].at(NoV), 1e-6)
                    << fresnel.name << " at NoV " << NoV;
            }
    }
}

TEST(Models, EveryFresnelOverGgx) {
    for (const FresnelCase& fresnel : every_fresnel()) {
        JobSpec job = model_job({Quantity::specular_albedo, Quantity::fresnel_average});
        job.fresnel = fresnel.model;
        const Outcome outcome = bake(job);
        const std::size_t colours = fresnel.channels.size();
        const std::string label = fresnel.name + std::to_string(colours);
        ASSERT_EQ(outcome.table.planes.size(), 2 * colours) << label;
        for (std::size_t c = 0; c < colours; ++c) {
            const reference::Fresnel& F = fresnel.channels[c];
            hold(outcome, c,
                 over_texels(job,
                             [&](double NoV, double roughness) {
                                 return reference::microfacet_albedo(ggx(roughness), NoV, F);
                             }),
                 label);
            hold(outcome, colours + c,
                 over_lines(job, [&](double) { return reference::fresnel_average(F); }), label,
                 1e-7);
        }
    }
}

// The lobes of the general path take a Fresnel term through other lines than GGX under Smith does.
TEST(Models, FresnelOverBeckmannAndCharlie) {
    const FresnelCase fresnel = conductor();
    for (const Distribution distribution : {Distribution::beckmann, Distribution::charlie}) {
        const bool charlie = distribution == Distribution::charlie;
        JobSpec job = model_job({Quantity::specular_albedo});
        job.distribution = distribution;
        job.masking = charlie ? Masking::neubelt : Masking::smith_correlated;
        job.importance = charlie ? Importance::uniform : Importance::vndf;
        job.fresnel = fresnel.model;
        const Outcome outcome = bake(job);
        for (std::size_t c = 0; c < 3; ++c)
            hold(outcome, c,
                 over_texels(job,
                             [&](double NoV, double roughness) {
                                 reference::Microfacet lobe = ggx(roughness);
                                 lobe.distribution = charlie ? reference::Distribution::charlie
                                                             : reference::Distribution::beckmann;
                                 if (charlie) lobe.visibility = reference::Visibility::neubelt;
                                 return reference::microfacet_albedo(lobe, NoV,
                                                                     fresnel.channels[c]);
                             }),
                 charlie ? "charlie" : "beckmann");
    }
}

// Lights of both sides of the critical angle are drawn as GGX's visible normals, whose density
// Beckmann's over it weighs (kernels/sample_lobe.h).
TEST(Models, TotalReflectionUnderBeckmann) {
    const FresnelCase fresnel = dielectric({0.7});
    JobSpec job = model_job({Quantity::specular_albedo});
    job.distribution = Distribution::beckmann;
    job.fresnel = fresnel.model;
    hold(bake(job), 0,
         over_texels(job,
                     [&](double NoV, double roughness) {
                         reference::Microfacet lobe = ggx(roughness);
                         lobe.distribution = reference::Distribution::beckmann;
                         return reference::microfacet_albedo(lobe, NoV, fresnel.channels[0]);
                     }),
         "beckmann");
}

// Where the averages are no quadrature's but sampled as well.
TEST(Models, MultiscatterOverBeckmann) {
    const FresnelCase fresnel = schlick({0.3}, 1, 5);
    JobSpec job = model_job({Quantity::compensated_albedo});
    job.distribution = Distribution::beckmann;
    job.fresnel = fresnel.model;
    job.multiscatter = Multiscatter::kulla_conty;
    Values truth;
    for (const double roughness : roughnesses(job)) {
        reference::Microfacet lobe = ggx(roughness);
        lobe.distribution = reference::Distribution::beckmann;
        const reference::SpecularAlbedo line(
            reference::Specular{lobe, fresnel.channels[0], reference::Multiscatter::kulla_conty});
        for (const double NoV : against_reference::positions(job.axes[0], job.resolution[0]))
            truth.push_back(line.at(NoV));
    }
    hold(bake(job), 0, truth, "beckmann");
}

TEST(Models, EveryMultiscatterCompensates) {
    for (const MultiscatterCase& one : every_multiscatter()) {
        JobSpec job = model_job({Quantity::compensated_albedo});
        job.fresnel = one.fresnel.model;
        job.multiscatter = one.ours;
        const Outcome outcome = bake(job);
        for (std::size_t c = 0; c < one.fresnel.channels.size(); ++c) {
            std::vector<reference::SpecularAlbedo> lines;
            for (const double roughness : roughnesses(job))
                lines.emplace_back(
                    reference::Specular{ggx(roughness), one.fresnel.channels[c], one.theirs});
            hold(outcome, c,
                 over_texels(job,
                             [&](double NoV, double roughness) {
                                 const bool first = roughness == roughnesses(job)[0];
                                 return lines[first ? 0 : 1].at(NoV);
                             }),
                 one.name);
        }
    }
}

}  // namespace
}  // namespace kiln
