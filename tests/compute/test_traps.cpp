// SPDX-License-Identifier: Apache-2.0
// Figure N20: no kernel divides by zero, overflows or makes a NaN on the way to its values, stiff
// places and both ends included. The flags of IEEE 754 stick to the thread that raised them, so one
// thread runs everything.
#include <gtest/gtest.h>

#include <cfenv>
#include <string>
#include <vector>

#include "server/compute/fresnel.h"
#include "server/compute/native.h"
#include "server/compute/plan.h"
#include "server/compute/quadrature.h"

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

/// Every pair of the stiff values.
Stiff stiff_places() {
    Stiff places;
    for (const double NoV : {0.0, 1e-6, 1e-4, 1e-2, 0.3, 1.0})
        for (const double alpha : {0.0, 1e-6, 1e-4, 1e-2, 0.3, 1.0, 1.0, 1.0}) {
            places.NoV.push_back(NoV);
            places.alpha.push_back(alpha);
        }
    return places;
}

/// The flags that one launch raises.
template <typename Scalar>
std::string flags_of(Backend& backend, const KernelMaterial& what, const FresnelModel& fresnel) {
    const Stiff places = stiff_places();
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
    std::vector<FresnelModel> models(5);
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
    return models;
}

class Traps : public testing::Test {
  protected:
    void hold(const KernelMaterial& what, const FresnelModel& fresnel, const std::string& name) {
        EXPECT_EQ(flags_of<float>(*backend_, what, fresnel), "") << name << ", float";
        EXPECT_EQ(flags_of<double>(*backend_, what, fresnel), "") << name << ", double";
    }
    ThreadPool pool_{1};
    std::unique_ptr<Backend> backend_ =
        make_native_backend(pool_, usable_instruction_sets().front());
};

TEST_F(Traps, N20SpecularLobes) {
    for (const int masking : {0, 1})
        for (const int importance : {0, 1, kVisibleLights})
            for (const int averaged : {0, 1}) {
                KernelMaterial what;
                what.masking = masking;
                what.importance = importance;
                what.averaged = averaged;
                what.terms = importance == kVisibleLights ? 3 : 7;
                if (importance == kVisibleLights && averaged) continue;
                hold(what, {}, "masking " + std::to_string(masking));
                what.general = 1;
                what.terms |= 7 << kColour;
                for (const FresnelModel& fresnel : fresnel_models()) {
                    what.fresnel = fresnel_function(fresnel);
                    hold(what, fresnel, "fresnel " + std::to_string(what.fresnel));
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

// The rule of every lobe, where no exp() is in it: those of lane_math.h compute both sides of a
// choice, and of the one that is not taken flags stay.
TEST_F(Traps, N20QuadratureOfLobes) {
    constexpr int kGgx = 0, kDielectric = 3;
    const Stiff places = stiff_places();
    for (const Precision precision : {Precision::float32, Precision::float64})
        for (const int masking : {0, 2, 4})
            for (const bool total : {false, true}) {
                const LobeRule rule{kGgx, masking, total ? kDielectric : kSchlickWeight, total};
                const QuadratureKind kind{rule, precision};
                const QuadratureParameters parameters = any_quadrature_parameters(kind);
                std::feclearexcept(kTraps);
                integrate_quadrature(*backend_, kind, {places.NoV, places.alpha, parameters, {}},
                                     {1e-5, 0});
                EXPECT_EQ(raised(), "") << "masking " << masking << ", total " << total;
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
    EXPECT_NE(flags_of<float>(*backend_, what, {}), "");
}

}  // namespace
}  // namespace kiln
