// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "server/spec/words.h"
#include "tests/compute/models.h"

// Diffuse lobes, alone and under a specular one.
namespace kiln {
namespace {

using namespace models;

struct DiffuseCase {
    DiffuseModel ours;
    reference::DiffuseModel theirs;
};

const std::vector<DiffuseCase> kDiffuse = {
    {DiffuseModel::lambert, reference::DiffuseModel::lambert},
    {DiffuseModel::burley, reference::DiffuseModel::burley},
    {DiffuseModel::oren_nayar, reference::DiffuseModel::oren_nayar},
    {DiffuseModel::oren_nayar_full, reference::DiffuseModel::oren_nayar_full},
    {DiffuseModel::fon, reference::DiffuseModel::fon},
    {DiffuseModel::eon, reference::DiffuseModel::eon},
    {DiffuseModel::eon_unreal, reference::DiffuseModel::eon_unreal},
    {DiffuseModel::chan2018, reference::DiffuseModel::chan2018},
    {DiffuseModel::chan2024, reference::DiffuseModel::chan2024},
};

void hold_diffuse(const DiffuseCase& model, const std::vector<double>& albedo, bool averages) {
    JobSpec job = model_job({Quantity::diffuse_albedo});
    if (averages) job.quantities.push_back(Quantity::diffuse_average_albedo);
    job.diffuse.model = model.ours;
    job.diffuse.albedo = albedo;
    const Outcome outcome = bake(job);
    ASSERT_EQ(outcome.table.planes.size(), job.quantities.size() * albedo.size());
    const std::string label(to_word(model.ours));
    for (std::size_t c = 0; c < albedo.size(); ++c) {
        hold(outcome, c,
             over_texels(
                 job,
                 [&](double NoV, double roughness) {
                     return reference::diffuse_albedo({model.theirs, roughness, albedo[c]}, NoV);
                 }),
             label);
        if (!averages) continue;
        hold(outcome, albedo.size() + c,
             over_lines(job,
                        [&](double roughness) {
                            return reference::diffuse_average({model.theirs, roughness, albedo[c]});
                        }),
             label);
    }
}

TEST(Models, EveryDiffuseLobe) {
    for (const DiffuseCase& model : kDiffuse) hold_diffuse(model, {0.8}, true);
}

// eon, eon_unreal and oren_nayar_full are not proportional to the albedo.
TEST(Models, EveryDiffuseLobeInThreeChannels) {
    for (const DiffuseCase& model : kDiffuse) hold_diffuse(model, {1, 0.5, 0}, false);
}

struct MaterialCase {
    Coupling ours;
    reference::Coupling theirs;
    DiffuseCase diffuse;
    std::vector<double> albedo;
    Multiscatter multiscatter;
    double ior;
};

void hold_material(const MaterialCase& material) {
    JobSpec job = model_job({Quantity::total_albedo});
    job.coupling = material.ours;
    job.multiscatter = material.multiscatter;
    job.diffuse.model = material.diffuse.ours;
    job.diffuse.albedo = material.albedo;
    job.fresnel.model = Fresnel::dielectric;
    job.fresnel.ior = {material.ior};
    const Outcome outcome = bake(job);
    ASSERT_EQ(outcome.table.planes.size(), material.albedo.size());
    const auto multiscatter =
        material.multiscatter == Multiscatter::none      ? reference::Multiscatter::none
        : material.multiscatter == Multiscatter::turquin ? reference::Multiscatter::turquin
                                                         : reference::Multiscatter::kulla_conty;
    const auto fresnel = reference::fresnel_dielectric(material.ior);
    for (std::size_t c = 0; c < material.albedo.size(); ++c) {
        Values truth;
        for (const double roughness : roughnesses(job)) {
            const reference::Microfacet lobe{reference::Distribution::ggx,
                                             reference::Visibility::smith_correlated,
                                             roughness * roughness};
            const reference::Material made(
                material.theirs, {lobe, fresnel, multiscatter},
                {material.diffuse.theirs, roughness, material.albedo[c]});
            for (const double NoV : against_reference::positions(job.axes[0], job.resolution[0]))
                truth.push_back(made.total(NoV));
        }
        hold(
            outcome, c, truth,
            std::string(to_word(material.ours)) + '_' + std::string(to_word(material.diffuse.ours)),
            // total reflection has a kink (test_models_fresnel.cpp)
            fresnel.kinks.empty() ? kExact : 2e-5);
    }
}

TEST(Models, EveryCouplingInTheFurnace) {
    const DiffuseCase lambert = kDiffuse[0], burley = kDiffuse[1], eon = kDiffuse[5];
    const Coupling half = Coupling::half_vector, view = Coupling::view, kelemen = Coupling::kelemen;
    const auto their_half = reference::Coupling::half_vector,
               their_view = reference::Coupling::view;
    const auto their_kelemen = reference::Coupling::kelemen, theirs = reference::Coupling::none;
    const Multiscatter single = Multiscatter::none, kulla_conty = Multiscatter::kulla_conty;
    const std::vector<double> grey = {0.8}, colours = {1, 0.5, 0};
    hold_material({Coupling::none, theirs, burley, grey, kulla_conty, 1.5});
    hold_material({Coupling::none, theirs, eon, colours, single, 1.5});
    hold_material({half, their_half, eon, colours, Multiscatter::turquin, 1.5});
    hold_material({half, their_half, burley, grey, kulla_conty, 1 / 1.5});
    hold_material({view, their_view, burley, colours, single, 1.5});
    hold_material({view, their_view, lambert, grey, single, 1 / 1.5});
    hold_material({kelemen, their_kelemen, lambert, colours, single, 1.5});
    hold_material({kelemen, their_kelemen, lambert, grey, kulla_conty, 1.5});
}

}  // namespace
}  // namespace kiln
