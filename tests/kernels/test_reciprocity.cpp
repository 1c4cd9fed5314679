// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "server/compute/fresnel.h"
#include "server/spec/contract.h"
#include "server/spec/spec.h"
#include "server/spec/words.h"
#include "tests/kernels/one_lane.h"

// f(V, L) beside f(L, V), in float as tables are computed: Helmholtz reciprocity of the lobes as
// the kernels evaluate them.
namespace {

using in_float::Scattering;

constexpr int kPairs = 1000000;

struct Pair {
    float NoV, NoL, sinL, cos_phi, alpha;
};

/// Directions even over the hemisphere, alpha even over [.01, 1].
class Pairs {
  public:
    Pair operator()() {
        const float NoL = cosine_();
        return {cosine_(), NoL, sine(NoL), std::cos(azimuth_(engine_)), width_(engine_)};
    }
    static float sine(float cosine) { return std::sqrt((1 - cosine) * (1 + cosine)); }

  private:
    float cosine_() { return cosines_(engine_); }
    std::mt19937_64 engine_{17};
    std::uniform_real_distribution<float> cosines_{1e-3f, 1}, azimuth_{0, 3.14159265f},
        width_{0.01f, 1};
};

Pair swapped(Pair pair) {
    return {pair.NoL, pair.NoV, Pairs::sine(pair.NoV), pair.cos_phi, pair.alpha};
}

/// The largest |f(V, L) − f(L, V)| over the greater of the two, of all pairs.
double worst(const std::function<float(const Pair&)>& lobe) {
    Pairs pairs;
    double most = 0;
    for (int i = 0; i < kPairs; ++i) {
        const Pair pair = pairs();
        const double there = lobe(pair), back = lobe(swapped(pair));
        const double size = std::max(there, back);
        EXPECT_TRUE(std::isfinite(there) && std::isfinite(back));
        // Beckmann's and Charlie's peaks fall below the least float.
        if (size > 1e-30) most = std::max(most, std::abs(there - back) / size);
    }
    return most;
}

/// F in float, as a launch has it.
class FresnelTerm {
  public:
    explicit FresnelTerm(const kiln::FresnelModel& model)
        : function_(kiln::fresnel_function(model)) {
        const auto parameters = kiln::fresnel_parameters(model, 0);
        std::transform(parameters.begin(), parameters.end(), parameters_.begin(),
                       [](double value) { return static_cast<float>(value); });
    }
    float operator()(float VoH) const {
        return in_float::fresnel(function_, parameters_.data(), VoH);
    }

  private:
    int function_;
    std::array<float, KILN_FRESNEL_PARAMETERS> parameters_{};
};

float specular(const Pair& pair, int distribution, int masking, const FresnelTerm& F) {
    const Scattering s = in_float::scatter_hemisphere(KILN_IMPORTANCE_COSINE, pair.NoV,
                                                      pair.cos_phi, pair.NoL, pair.sinL);
    const float D = in_float::microfacet_D(distribution, pair.alpha, s.NoV, s.NoH, s.sin2_H);
    return in_float::microfacet_product(distribution, masking, pair.alpha, s, D) * F(s.VoH);
}

float ggx(const Pair& pair, const FresnelTerm& F) {
    return specular(pair, KILN_DISTRIBUTION_GGX, KILN_MASKING_SMITH_CORRELATED, F);
}

double worst_specular(int distribution, int masking) {
    const FresnelTerm schlick(kiln::FresnelModel{});
    return worst([&](const Pair& pair) { return specular(pair, distribution, masking, schlick); });
}

// Swapping the arguments changes the order of a sum or of a product: some roundings of 6e-8, not
// 1e-5.
constexpr double kReciprocal = 1e-5;

struct Named {
    const char* name;
    int distribution, masking;
};

/// Pairs of a distribution and a masking that a job may name.
std::size_t lobes_of_the_contract() {
    std::size_t count = 0;
    for (const std::string_view distribution : kiln::words<kiln::Distribution>())
        for (const std::string_view masking : kiln::words<kiln::Masking>()) {
            const std::string lobe = R"("distribution":")" + std::string(distribution) +
                                     R"(","masking":")" + std::string(masking) + "\"";
            try {
                kiln::parse_job(R"({"quantities":["directional_albedo"],"microfacet":{)" + lobe +
                                "}}");
                ++count;
            } catch (const kiln::InvalidJob&) {
            }
        }
    return count;
}

TEST(Reciprocity, EveryReciprocalSpecularLobe) {
    const Named lobes[] = {
        {"ggx smith_correlated", KILN_DISTRIBUTION_GGX, KILN_MASKING_SMITH_CORRELATED},
        {"ggx smith_separable", KILN_DISTRIBUTION_GGX, KILN_MASKING_SMITH_SEPARABLE},
        {"ggx karis_ibl", KILN_DISTRIBUTION_GGX, KILN_MASKING_KARIS_IBL},
        {"ggx karis_direct", KILN_DISTRIBUTION_GGX, KILN_MASKING_KARIS_DIRECT},
        {"ggx unreal_joint", KILN_DISTRIBUTION_GGX, KILN_MASKING_UNREAL_JOINT},
        {"beckmann smith_correlated", KILN_DISTRIBUTION_BECKMANN, KILN_MASKING_SMITH_CORRELATED},
        {"beckmann smith_separable", KILN_DISTRIBUTION_BECKMANN, KILN_MASKING_SMITH_SEPARABLE},
        {"charlie neubelt", KILN_DISTRIBUTION_CHARLIE, KILN_MASKING_NEUBELT},
        {"charlie charlie", KILN_DISTRIBUTION_CHARLIE, KILN_MASKING_CHARLIE},
    };
    ASSERT_EQ(std::size(lobes), lobes_of_the_contract());
    for (const Named& lobe : lobes) {
        const double found = worst_specular(lobe.distribution, lobe.masking);
        EXPECT_LE(found, kReciprocal) << lobe.name;
        RecordProperty(lobe.name, std::to_string(found * 1e6) + "e-6");
    }
}

TEST(Reciprocity, SoftenedCharlieIsNotReciprocal) {
    EXPECT_GT(worst_specular(KILN_DISTRIBUTION_CHARLIE, KILN_MASKING_CHARLIE_SOFTENED), 0.1);
}

kiln::FresnelModel dielectric(double ior) {
    kiln::FresnelModel model{.model = kiln::Fresnel::dielectric};
    model.ior = {ior};
    return model;
}

std::vector<kiln::FresnelModel> every_fresnel() {
    kiln::FresnelModel power{.model = kiln::Fresnel::schlick, .exponent = 3.5};
    kiln::FresnelModel conductor{.model = kiln::Fresnel::conductor};
    conductor.eta = {0.2};
    conductor.k = {3.9};
    kiln::FresnelModel edge{.model = kiln::Fresnel::edge_tint};
    edge.reflectivity = {0.64};
    edge.edge_tint = {0.5};
    kiln::FresnelModel f82{.model = kiln::Fresnel::f82_tint};
    f82.f0 = {0.6};
    f82.f82 = {0.3};
    return {{.model = kiln::Fresnel::none},
            {.model = kiln::Fresnel::schlick},
            power,
            dielectric(1.5),
            dielectric(1 / 1.5),
            conductor,
            edge,
            f82};
}

TEST(Reciprocity, EveryFresnelTerm) {
    const auto models = every_fresnel();
    for (const std::string_view word : kiln::words<kiln::Fresnel>())
        EXPECT_TRUE(std::any_of(models.begin(), models.end(), [&](const auto& model) {
            return to_word(model.model) == word;
        })) << word;
    for (std::size_t i = 0; i < models.size(); ++i) {
        const FresnelTerm F(models[i]);
        const double found = worst([&](const Pair& pair) { return ggx(pair, F); });
        const std::string name = std::string(to_word(models[i].model)) + std::to_string(i);
        EXPECT_LE(found, kReciprocal) << name;
        RecordProperty(name, std::to_string(found * 1e6) + "e-6");
    }
}

float diffuse(const Pair& pair, int model, const std::function<float(float)>& weight) {
    const auto d = in_float::diffuse_directions(pair.NoV, pair.NoL, pair.sinL, pair.cos_phi);
    return in_float::diffuse_lobe(model, d, pair.alpha, 0.8f) * weight(d.VoH);
}

double worst_diffuse(int model) {
    return worst([=](const Pair& pair) { return diffuse(pair, model, [](float) { return 1.f; }); });
}

/// Over GGX, as the couplings none and half_vector join both.
double worst_material(int model, kiln::Coupling coupling) {
    const FresnelTerm F(dielectric(1.5));
    return worst([&](const Pair& pair) {
        const auto weight = [&](float VoH) {
            return coupling == kiln::Coupling::none ? 1.f : 1 - F(VoH);
        };
        return ggx(pair, F) + 0.318309886f * diffuse(pair, model, weight);
    });
}

struct DiffuseRow {
    int number;
    const char* word;
    bool is_lobe, reciprocal;
};

std::vector<DiffuseRow> diffuse_rows() {
    std::vector<DiffuseRow> rows;
    const auto add = [&](int number, const char* word) {
        const auto model = kiln::from_word<kiln::DiffuseModel>(word).value();
        rows.push_back({number, word, model != kiln::DiffuseModel::ggx_lambert,
                        !kiln::known_of(model).not_reciprocal});
    };
#define KILN_TEST_ROW(number, word) add(KILN_DIFFUSE_##number, #word);
    KILN_DIFFUSE_ROWS(KILN_TEST_ROW)
    return rows;
}

TEST(Reciprocity, EveryDiffuseLobeIsReciprocalOrKnownNotToBe) {
    for (const DiffuseRow& row : diffuse_rows()) {
        if (!row.is_lobe) continue;
        const double found = worst_diffuse(row.number);
        RecordProperty(row.word, std::to_string(found * 1e6) + "e-6");
        if (row.reciprocal)
            EXPECT_LE(found, kReciprocal) << row.word;
        else
            EXPECT_GT(found, 0.01) << row.word;
    }
}

// Kelemen's lobe and what Kulla and Conty add are no kernel's terms: tables hold their integrals,
// made of albedos. The furnace study looks at them in double.
TEST(Reciprocity, EveryMaterialThatKernelsJoin) {
    for (const DiffuseRow& row : diffuse_rows())
        for (const auto coupling : {kiln::Coupling::none, kiln::Coupling::half_vector}) {
            if (!row.is_lobe || !row.reciprocal) continue;
            const double found = worst_material(row.number, coupling);
            const std::string name = row.word + ('_' + std::string(to_word(coupling)));
            EXPECT_LE(found, kReciprocal) << name;
            RecordProperty(name, std::to_string(found * 1e6) + "e-6");
        }
}

}  // namespace
