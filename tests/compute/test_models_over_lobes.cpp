// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "server/spec/words.h"
#include "tests/compute/models.h"

// Materials and compensations over specular lobes other than GGX under Smith, and under Fresnel
// terms other than a dielectric's.
namespace kiln {
namespace {

using namespace models;

struct Lobe {
    Distribution distribution;
    Masking masking;
    Importance importance;
    reference::Distribution their_distribution;
    reference::Visibility their_visibility;
};

const Lobe kGgx{Distribution::ggx, Masking::smith_correlated, Importance::vndf,
                reference::Distribution::ggx, reference::Visibility::smith_correlated};
const Lobe kBeckmann{Distribution::beckmann, Masking::smith_correlated, Importance::vndf,
                     reference::Distribution::beckmann, reference::Visibility::smith_correlated};
const Lobe kCharlie{Distribution::charlie, Masking::neubelt, Importance::uniform,
                    reference::Distribution::charlie, reference::Visibility::neubelt};
const Lobe kKaris{Distribution::ggx, Masking::karis_ibl, Importance::vndf,
                  reference::Distribution::ggx, reference::Visibility::karis_ibl};

struct Tint {
    FresnelModel ours;
    reference::Fresnel theirs;
};

Tint f82_tint() {
    Tint tint{{}, reference::fresnel_f82_tint(0.6, 0.3)};
    tint.ours.model = Fresnel::f82_tint;
    tint.ours.f0 = {0.6};
    tint.ours.f82 = {0.3};
    return tint;
}

Tint edge_tint() {
    Tint tint{{}, reference::fresnel_edge_tint(0.64, 0.5)};
    tint.ours.model = Fresnel::edge_tint;
    tint.ours.reflectivity = {0.64};
    tint.ours.edge_tint = {0.5};
    return tint;
}

struct Compensation {
    Multiscatter ours;
    reference::Multiscatter theirs;
};
const Compensation kNone{Multiscatter::none, reference::Multiscatter::none};
const Compensation kSquared{Multiscatter::kulla_conty, reference::Multiscatter::kulla_conty};
const Compensation kLinear{Multiscatter::kulla_conty_linear,
                           reference::Multiscatter::kulla_conty_first_power};
const Compensation kTurquin{Multiscatter::turquin, reference::Multiscatter::turquin};

JobSpec job_of(Quantity quantity, const Lobe& lobe, const Tint& tint, const Compensation& back) {
    JobSpec job = model_job({quantity});
    job.distribution = lobe.distribution;
    job.masking = lobe.masking;
    job.importance = lobe.importance;
    job.fresnel = tint.ours;
    job.multiscatter = back.ours;
    return job;
}

std::string label_of(const Lobe& lobe, const Compensation& back) {
    return std::string(to_word(lobe.distribution)) + '_' + std::string(to_word(lobe.masking)) +
           '_' + std::string(to_word(back.ours));
}

reference::Specular theirs(const Lobe& lobe, double roughness, const Tint& tint,
                           const Compensation& back) {
    return {{lobe.their_distribution, lobe.their_visibility, roughness * roughness},
            tint.theirs,
            back.theirs};
}

void hold_compensated(const Lobe& lobe, const Tint& tint, const Compensation& back) {
    JobSpec job = job_of(Quantity::compensated_albedo, lobe, tint, back);
    // Kulla and Conty's average over Charlie has a standard error of 6.5e-6 at an eighth.
    if (lobe.distribution != Distribution::charlie) job.sample_count = few_samples();
    Values truth;
    for (const double roughness : roughnesses(job)) {
        const reference::SpecularAlbedo line(theirs(lobe, roughness, tint, back));
        for (const double NoV : against_reference::positions(job.axes[0], job.resolution[0]))
            truth.push_back(line.at(NoV));
    }
    hold(bake(job), 0, truth, label_of(lobe, back));
}

// An average over Beckmann or Charlie is sampled as well.
TEST(OverLobes, EveryCompensation) {
    for (const Lobe& lobe : {kBeckmann, kCharlie})
        for (const Compensation& back : {kLinear, kTurquin})
            hold_compensated(lobe, f82_tint(), back);
    hold_compensated(kKaris, f82_tint(), kTurquin);
    for (const Compensation& back : {kSquared, kLinear, kTurquin})
        hold_compensated(kGgx, edge_tint(), back);
}

struct Over {
    Coupling ours;
    reference::Coupling theirs;
    DiffuseModel diffuse;
};

// Lambert is what `kelemen` takes.
const Over kCouplings[] = {
    {Coupling::none, reference::Coupling::none, DiffuseModel::eon},
    {Coupling::half_vector, reference::Coupling::half_vector, DiffuseModel::burley},
    {Coupling::view, reference::Coupling::view, DiffuseModel::fon},
    {Coupling::kelemen, reference::Coupling::kelemen, DiffuseModel::lambert},
};

void hold_total(const Lobe& lobe, const Tint& tint, const Compensation& back, const Over& over) {
    constexpr double kAlbedo = 0.8;
    JobSpec job = job_of(Quantity::total_albedo, lobe, tint, back);
    job.coupling = over.ours;
    // Under `view` that of karis_ibl is 3e-6 there.
    if (over.ours != Coupling::view) job.sample_count = few_samples();
    job.diffuse.model = over.diffuse;
    job.diffuse.albedo = {kAlbedo};
    Values truth;
    for (const double roughness : roughnesses(job)) {
        const reference::Material made(
            over.theirs, theirs(lobe, roughness, tint, back),
            {reference::diffuse_model(to_word(over.diffuse)), roughness, kAlbedo});
        for (const double NoV : against_reference::positions(job.axes[0], job.resolution[0]))
            truth.push_back(made.total(NoV));
    }
    hold(bake(job), 0, truth, label_of(lobe, back) + '_' + std::string(to_word(over.ours)));
}

// Under `view` there is nothing to compensate by.
TEST(OverLobes, TotalUnderEveryCoupling) {
    ASSERT_EQ(words<Coupling>().size(), std::size(kCouplings));
    for (const Over& over : kCouplings) {
        const bool view = over.ours == Coupling::view;
        hold_total(kBeckmann, f82_tint(), view ? kNone : kSquared, over);
        hold_total(kCharlie, edge_tint(), view ? kNone : kTurquin, over);
        hold_total(kKaris, f82_tint(), view ? kNone : kLinear, over);
    }
}

TEST(OverLobes, SheenIsCharlieUnderNeubelt) {
    const JobSpec job = model_job({Quantity::sheen_albedo});
    hold(bake(job), 0,
         over_texels(job,
                     [](double NoV, double roughness) {
                         return reference::microfacet_albedo(
                             {reference::Distribution::charlie, reference::Visibility::neubelt,
                              roughness * roughness},
                             NoV);
                     }),
         "sheen");
}

}  // namespace
}  // namespace kiln
