// SPDX-License-Identifier: Apache-2.0
// Figure N20: no kernel divides by zero, overflows or makes a NaN on the way to its values, stiff
// places and both ends included. The flags of IEEE 754 stick to the thread that raised them, so one
// thread runs everything.
#include <gtest/gtest.h>

#include <algorithm>
#include <cfenv>
#include <set>
#include <string>
#include <vector>

#include "server/compute/fresnel.h"
#include "server/compute/native.h"
#include "server/compute/plan.h"
#include "server/compute/quadrature.h"
#include "server/spec/words.h"
#include "tests/compute/every_lobe.h"

namespace kiln {
namespace {

constexpr int kTraps = FE_INVALID | FE_DIVBYZERO | FE_OVERFLOW;

std::string raised() {
    std::string names;
    if (std::fetestexcept(FE_INVALID)) names += " invalid";
    if (std::fetestexcept(FE_DIVBYZERO)) names += " division by zero";
    if (std::fetestexcept(FE_OVERFLOW)) names += " overflow";
    return names;
}

struct Stiff {
    std::vector<double> NoV, alpha;
};

/// Every pair of the stiff values from these on.
Stiff stiff_places(double NoV_least = 0, double alpha_least = 0) {
    Stiff places;
    for (const double NoV : {0.0, 1e-6, 1e-4, 1e-2, 0.3, 1.0})
        for (const double alpha : {0.0, 1e-6, 1e-4, 1e-2, 0.3, 1.0, 1.0, 1.0}) {
            places.NoV.push_back(std::max(NoV, NoV_least));
            places.alpha.push_back(std::max(alpha, alpha_least));
        }
    return places;
}

bool draws_deficit_alone(int importance) {
    return importance == kLogTangents || importance == kHorizonNormals;
}

/// Where the lobe has a value: D itself, which cosine and uniform importance read, is infinite at
/// alpha = 0, and so are Charlie's maskings at NoV = 0. Of the divergence the flags are right.
/// Logarithms of tangents are of alpha > 0, parted lights of 1e-4 and more.
Stiff stiff_places(const KernelMaterial& what) {
    const bool specular = (what.terms & (7 | 7 << kColour)) != 0;
    const bool positive = what.importance == static_cast<int>(Importance::cosine) ||
                          what.importance == static_cast<int>(Importance::uniform) ||
                          draws_deficit_alone(what.importance);
    if (specular && what.importance == kPartedLights) return stiff_places(0, 1e-4);
    return stiff_places(is_charlie_fit(what.masking) ? 1e-6 : 0, specular && positive ? 1e-6 : 0);
}

/// The flags that one launch raises.
template <typename Scalar>
std::string flags_of(Backend& backend, const KernelMaterial& what, const FresnelModel& fresnel,
                     const Stiff& places) {
    std::vector<Scalar> texels(places.NoV.begin(), places.NoV.end());
    texels.insert(texels.end(), places.alpha.begin(), places.alpha.end());
    for (std::size_t i = 0; i < places.NoV.size() && what.importance == kVisibleLights; ++i)
        texels[i] = static_cast<Scalar>(std::max(places.NoV[i], places.alpha[i] / 2));  // their own
    std::vector<Scalar> parameters(kParameterCount, Scalar(0.5));
    const auto numbers = fresnel_parameters(fresnel, 0);
    for (std::size_t c = 0; c < 3; ++c)
        for (std::size_t k = 0; k < numbers.size(); ++k)
            parameters[c * numbers.size() + k] = static_cast<Scalar>(numbers[k]);
    const PointSet set = make_points(Sampler::sobol_owen, point_kind(what), 7, 1024);
    const std::vector<Scalar> points(set.values.begin(), set.values.end());
    const auto planes =
        static_cast<std::size_t>(__builtin_popcount(static_cast<unsigned>(what.terms)));
    std::vector<Scalar> sums(set.batches.size() * planes * places.NoV.size());
    const Precision precision =
        sizeof(Scalar) == sizeof(float) ? Precision::float32 : Precision::float64;
    std::feclearexcept(kTraps);
    backend.run(Launch<Scalar>{
        {what, precision}, places.NoV.size(), texels, points, parameters, set.batches, sums});
    return raised();
}

std::vector<FresnelModel> fresnel_models() {
    std::vector<FresnelModel> models(7);
    models[0].model = Fresnel::schlick;
    models[1].model = models[2].model = Fresnel::dielectric;
    models[1].ior = {1.0000001};
    models[2].ior = {1 / 1.5};
    models[3].model = Fresnel::conductor;
    models[3].eta = {1e-4};
    models[3].k = {5};
    models[4].model = Fresnel::edge_tint;
    models[4].reflectivity = {0.9};
    models[4].edge_tint = {0.5};
    models[5].model = Fresnel::schlick;
    models[5].exponent = 1000;
    models[6].model = Fresnel::f82_tint;
    models[6].f0 = {0.9};
    models[6].f82 = {0.1};
    return models;
}

class Traps : public testing::Test {
  protected:
    void hold(const KernelMaterial& what, const FresnelModel& fresnel, const std::string& name) {
        const Stiff places = stiff_places(what);
        EXPECT_EQ(flags_of<float>(*backend_, what, fresnel, places), "") << name << ", float";
        EXPECT_EQ(flags_of<double>(*backend_, what, fresnel, places), "") << name << ", double";
    }
    ThreadPool pool_{1};
    std::unique_ptr<Backend> backend_ =
        make_native_backend(pool_, usable_instruction_sets().front());
};

std::string name_of(const KernelMaterial& what) {
    return "distribution " + std::to_string(what.distribution) + ", masking " +
           std::to_string(what.masking) + ", importance " + std::to_string(what.importance) +
           ", averaged " + std::to_string(what.averaged) + ", fresnel " +
           std::to_string(what.fresnel) + ", diffuse " + std::to_string(what.diffuse);
}

TEST_F(Traps, N20SpecularLobes) {
    std::set<int> held;
    for (const KernelMaterial& lobe : every_lobe()) {
        held.insert(lobe.distribution);
        for (const int averaged : {0, 1}) {
            KernelMaterial what = lobe;
            what.averaged = averaged;
            what.general = 1;
            what.terms = 7 | 7 << kColour;
            for (const FresnelModel& fresnel : fresnel_models()) {
                what.fresnel = fresnel_function(fresnel);
                hold(what, fresnel, name_of(what));
            }
        }
    }
    EXPECT_EQ(held.size(), words<Distribution>().size());
}

// GGX under Smith, whose kernels are their own, and the samplers that no job names.
TEST_F(Traps, N20FastLobes) {
    for (const int masking : {0, 1})
        for (const int importance : {0, 1, kLogTangents, kVisibleLights, kHorizonNormals})
            for (const int averaged : {0, 1}) {
                KernelMaterial what;
                what.masking = masking;
                what.importance = importance;
                what.averaged = averaged;
                what.terms = importance == kVisibleLights ? 3 : 7;
                if (draws_deficit_alone(importance)) what.terms = 1 << kDeficit;
                if (importance >= kLogTangents && averaged != (importance == kHorizonNormals))
                    continue;
                hold(what, {}, name_of(what));
            }
}

TEST_F(Traps, N20PartedLights) {
    FresnelModel inside;
    inside.model = Fresnel::dielectric;
    for (const double ior : {1e-4, 1 / 1.5, 1 - 1e-7})
        for (const int distribution : {0, 1})
            for (const int terms : {7 << kColour, 7 << kTransmitted}) {
                inside.ior = {ior};
                hold({.distribution = distribution,
                      .importance = kPartedLights,
                      .terms = terms,
                      .fresnel = fresnel_function(inside),
                      .diffuse = KILN_DIFFUSE_BURLEY,
                      .general = 1},
                     inside, "parted lights, ior " + std::to_string(ior));
            }
}

TEST_F(Traps, N20DiffuseLobes) {
    for (int diffuse = 0; diffuse < KILN_DIFFUSE_COUNT; ++diffuse)
        for (const int averaged : {0, 1}) {
            KernelMaterial what;
            what.importance = static_cast<int>(Importance::cosine);
            what.averaged = averaged;
            what.diffuse = diffuse;
            what.general = 1;
            what.terms = 7 << kDiffuse;
            hold(what, {}, name_of(what));
            if (diffuse == KILN_DIFFUSE_GGX_LAMBERT) continue;  // a walk meets no Fresnel term
            what.terms |= 7 << kTransmitted;
            for (const FresnelModel& fresnel : fresnel_models()) {
                what.fresnel = fresnel_function(fresnel);
                hold(what, fresnel, name_of(what));
            }
        }
}

TEST_F(Traps, N20Quadrature) {
    const Stiff places = stiff_places();
    for (const Precision precision : {Precision::float32, Precision::float64})
        for (const int fresnel : {kNoFresnel, kSchlickWeight}) {
            std::feclearexcept(kTraps);
            const SmithRule rule{Masking::smith_correlated, fresnel};
            integrate_quadrature(*backend_, {rule, precision}, {places.NoV, places.alpha, {}, {}},
                                 {1e-9, 0});
            EXPECT_EQ(raised(), "") << "fresnel " << fresnel;
        }
}

// Charlie's E has no bound where roughness and NoV vanish together.
TEST_F(Traps, N20QuadratureOfLobes) {
    constexpr int kDielectric = 3;
    std::set<int> held;
    for (const KernelMaterial& lobe : every_lobe()) {
        if (lobe.importance != static_cast<int>(Importance::uniform)) continue;  // each lobe once
        held.insert(lobe.distribution);
        for (const Precision precision : {Precision::float32, Precision::float64})
            for (const bool total : {false, true}) {
                const LobeRule rule{lobe.distribution, lobe.masking,
                                    total ? kDielectric : kSchlickWeight, total};
                const QuadratureKind kind{rule, precision};
                const QuadratureParameters parameters = any_quadrature_parameters(kind);
                const double least = lobe.distribution == KILN_DISTRIBUTION_CHARLIE ? 1e-6 : 0;
                const Stiff places = stiff_places(least, least);
                std::feclearexcept(kTraps);
                integrate_quadrature(*backend_, kind, {places.NoV, places.alpha, parameters, {}},
                                     {1e-5, 0});
                EXPECT_EQ(raised(), "")
                    << name_of(lobe) << ", total " << total << ", " << to_word(precision);
            }
    }
    EXPECT_EQ(held.size(), words<Distribution>().size());
}

TEST_F(Traps, N20QuadratureOfDiffuseLobes) {
    for (int diffuse = 0; diffuse < KILN_DIFFUSE_COUNT; ++diffuse) {
        if (diffuse == KILN_DIFFUSE_GGX_LAMBERT) continue;  // facet_space.h, on the host
        for (const Precision precision : {Precision::float32, Precision::float64})
            for (const FresnelModel& fresnel : fresnel_models()) {
                const DiffuseRule rule{diffuse, fresnel_function(fresnel)};
                const QuadratureKind kind{rule, precision};
                QuadratureParameters parameters{};
                const auto numbers = fresnel_parameters(fresnel, 0);
                std::copy(numbers.begin(), numbers.end(), parameters.begin());
                parameters[numbers.size()] = 1;
                const Stiff places = stiff_places();
                std::feclearexcept(kTraps);
                integrate_quadrature(*backend_, kind, {places.NoV, places.alpha, parameters, {}},
                                     {1e-5, 0});
                EXPECT_EQ(raised(), "") << "diffuse " << diffuse << ", fresnel " << rule.fresnel
                                        << ", " << to_word(precision);
            }
    }
}

TEST_F(Traps, AFlagIsSeen) {
    std::feclearexcept(kTraps);
    volatile double zero = 0, one = 1;
    volatile double quotient = one / zero;
    (void)quotient;
    EXPECT_EQ(raised(), " division by zero");
    // What no job can ask for at α = 0: D itself, which is infinite there.
    KernelMaterial what;
    what.importance = static_cast<int>(Importance::cosine);
    what.general = 1;
    what.terms = 1;
    EXPECT_NE(flags_of<float>(*backend_, what, {}, stiff_places()), "");
}

}  // namespace
}  // namespace kiln
