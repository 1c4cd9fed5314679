// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "server/spec/spec.h"
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

DiffuseCase diffuse_case(DiffuseModel model) {
    return {model, reference::diffuse_model(to_word(model))};
}

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
    for (const DiffuseModel model : diffuse_lobes()) hold_diffuse(diffuse_case(model), {0.8}, true);
}

// eon, eon_unreal and oren_nayar_full are not proportional to the albedo.
TEST(Models, EveryDiffuseLobeInThreeChannels) {
    for (const DiffuseModel model : diffuse_lobes())
        hold_diffuse(diffuse_case(model), {1, 0.5, 0}, false);
}

struct MaterialCase {
    Coupling coupling;
    DiffuseCase diffuse;
    std::vector<double> albedo;
    Multiscatter multiscatter;
    double ior;
};

reference::Coupling theirs(Coupling coupling) {
    return coupling == Coupling::none          ? reference::Coupling::none
           : coupling == Coupling::half_vector ? reference::Coupling::half_vector
           : coupling == Coupling::view        ? reference::Coupling::view
                                               : reference::Coupling::kelemen;
}

reference::Multiscatter theirs(Multiscatter multiscatter) {
    return multiscatter == Multiscatter::none      ? reference::Multiscatter::none
           : multiscatter == Multiscatter::turquin ? reference::Multiscatter::turquin
           : multiscatter == Multiscatter::kulla_conty
               ? reference::Multiscatter::kulla_conty
               : reference::Multiscatter::kulla_conty_first_power;
}

reference::Specular specular_of(const MaterialCase& material, double roughness) {
    const reference::Microfacet lobe{reference::Distribution::ggx,
                                     reference::Visibility::smith_correlated,
                                     roughness * roughness};
    return {lobe, reference::fresnel_dielectric(material.ior), theirs(material.multiscatter)};
}

JobSpec job_of(const MaterialCase& material) {
    JobSpec job = model_job({Quantity::total_albedo});
    job.coupling = material.coupling;
    job.multiscatter = material.multiscatter;
    job.diffuse.model = material.diffuse.ours;
    job.diffuse.albedo = material.albedo;
    job.fresnel.model = Fresnel::dielectric;
    job.fresnel.ior = {material.ior};
    return job;
}

void hold_material(const MaterialCase& material, std::int64_t sample_count) {
    JobSpec job = job_of(material);
    job.sample_count = sample_count;
    const Outcome outcome = bake(job);
    ASSERT_EQ(outcome.table.planes.size(), material.albedo.size());
    std::vector<reference::Specular> lines;
    for (const double roughness : roughnesses(job))
        lines.push_back(specular_of(material, roughness));
    for (std::size_t c = 0; c < material.albedo.size(); ++c) {
        Values truth;
        for (const reference::Specular& line : lines) {
            const reference::Material made(
                theirs(material.coupling), line,
                {material.diffuse.theirs, std::sqrt(line.lobe.alpha), material.albedo[c]});
            for (const double NoV : against_reference::positions(job.axes[0], job.resolution[0]))
                truth.push_back(made.total(NoV));
        }
        hold(outcome, c, truth,
             std::string(to_word(material.coupling)) + '_' +
                 std::string(to_word(material.diffuse.ours)) + '_' +
                 std::string(to_word(material.multiscatter)));
    }
}

/// Whether the contract lets a diffuse model under a coupling; no other reason may refuse the job.
bool is_allowed(std::string_view coupling, std::string_view diffuse) {
    try {
        parse_job(R"({"quantities":["total_albedo"],"coupling":")" + std::string(coupling) +
                  R"(","diffuse":{"model":")" + std::string(diffuse) + "\"}}");
    } catch (const InvalidJob& error) {
        EXPECT_EQ(error.problems.size(), 1U) << coupling << ' ' << diffuse;
        EXPECT_EQ(error.problems[0].pointer, "/coupling") << coupling << ' ' << diffuse;
        return false;
    }
    return true;
}

// Every diffuse lobe under every coupling that takes it, over each compensation in turn. Of what is
// no lobe, a walk is in test_models_simulated.cpp.
TEST(Models, EveryDiffuseLobeUnderEveryCoupling) {
    const auto multiscatters = words<Multiscatter>().size();
    std::size_t held = 0, turn = 0;
    for (std::size_t c = 0; c < words<Coupling>().size(); ++c)
        for (const DiffuseModel model : diffuse_lobes()) {
            const auto coupling = static_cast<Coupling>(c);
            if (!is_allowed(to_word(coupling), to_word(model))) {
                EXPECT_EQ(coupling, Coupling::kelemen) << to_word(model);
                EXPECT_NE(model, DiffuseModel::lambert);
                continue;
            }
            const auto compensation = coupling == Coupling::view
                                          ? Multiscatter::none
                                          : static_cast<Multiscatter>(turn++ % multiscatters);
            hold_material({coupling, diffuse_case(model), {turn % 2 ? 0.8 : 1}, compensation, 1.5},
                          few_samples());
            ++held;
        }
    EXPECT_EQ(held, 3 * diffuse_lobes().size() + 1);
}

TEST(Models, MaterialsOfThreeColoursAndOfTheDenserMedium) {
    const DiffuseCase lambert = diffuse_case(DiffuseModel::lambert);
    const DiffuseCase burley = diffuse_case(DiffuseModel::burley);
    const DiffuseCase eon = diffuse_case(DiffuseModel::eon);
    const std::vector<double> grey = {0.8}, colours = {1, 0.5, 0};
    hold_material({Coupling::half_vector, eon, colours, Multiscatter::turquin, 1.5}, samples());
    hold_material({Coupling::half_vector, burley, grey, Multiscatter::kulla_conty, 1 / 1.5},
                  samples());
    hold_material({Coupling::view, lambert, colours, Multiscatter::none, 1 / 1.5}, samples());
    hold_material({Coupling::kelemen, lambert, colours, Multiscatter::none, 1.5}, samples());
    hold_material({Coupling::kelemen, lambert, grey, Multiscatter::kulla_conty, 1.5}, samples());
}

}  // namespace
}  // namespace kiln
