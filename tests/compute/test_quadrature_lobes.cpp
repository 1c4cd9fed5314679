// SPDX-License-Identifier: Apache-2.0
// The quadrature of kernels/quadrature_lobe.h beside the one of tests/reference, which integrates
// over half vectors by another rule and shares no line with it: Beckmann, Charlie, GGX's other
// maskings, and total reflection.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "server/compute/native.h"
#include "server/compute/plan.h"
#include "server/compute/quadrature.h"
#include "server/compute/terms.h"
#include "tests/compute/every_lobe.h"
#include "tests/reference/microfacet_albedo.h"
#include "tests/reference/reference.h"

namespace kiln {
namespace {

constexpr int kGgx = 0, kBeckmann = 1, kCharlie = 2, kDielectric = 3;

using Pair = LobePair;
const std::vector<Pair> kLobes = lobes_of_the_general_rule();

KernelMaterial material(const Pair& lobe) {
    return {.distribution = lobe.distribution, .masking = lobe.masking};
}

/// The reference has both enumerations in the kernels' order.
reference::Microfacet in_reference(const Pair& lobe, double alpha) {
    return {static_cast<reference::Distribution>(lobe.distribution),
            static_cast<reference::Visibility>(lobe.masking), alpha};
}

struct Places {
    std::vector<double> NoV, alpha;
    Places(std::initializer_list<double> cosines, std::initializer_list<double> widths) {
        for (const double cosine : cosines)
            for (const double width : widths) {
                NoV.push_back(cosine);
                alpha.push_back(width);
            }
    }
};

class QuadratureOfLobes : public testing::Test {
  protected:
    QuadratureResult integrate(const Pair& lobe, int fresnel, const QuadratureParameters& p,
                               const Places& places, Precision precision, double tolerance) {
        const QuadratureKind kind = quadrature_kind(material(lobe), fresnel, p, precision);
        return integrate_quadrature(*backend_, kind, {places.NoV, places.alpha, p, {}},
                                    {tolerance, integrates_deficit(kind) ? 1e-7 : 0});
    }

    ThreadPool pool_{1};
    std::unique_ptr<Backend> backend_ =
        make_native_backend(pool_, usable_instruction_sets().front());
};

std::string text(const Pair& lobe, const Places& places, std::size_t i) {
    return "distribution " + std::to_string(lobe.distribution) + ", masking " +
           std::to_string(lobe.masking) + ", NoV " + std::to_string(places.NoV[i]) + ", alpha " +
           std::to_string(places.alpha[i]);
}

// The reference over half vectors has 1e-9 from alpha = 0.02 on, but for wide Beckmann lobes, of
// which it misses 4e-9 at grazing views; its second opinion, over lights, does not.
double truth_of(const reference::Microfacet& lobe, double NoV,
                const reference::Fresnel& fresnel = reference::fresnel_none()) {
    const bool wide = lobe.distribution == reference::Distribution::beckmann && lobe.alpha > 0.9;
    return wide ? reference::microfacet_albedo_over_light(lobe, NoV, fresnel)
                : reference::microfacet_albedo(lobe, NoV, fresnel);
}

// 1e-9 is promised, and so much the reference may be off by as well.
TEST_F(QuadratureOfLobes, HasTheAlbedosOfTheReference) {
    const Places places({1e-4, 3e-3, 0.05, 0.4, 0.93, 1.0}, {0.02, 0.2, 0.6});
    const auto schlick = reference::fresnel_schlick(0, 1);
    for (const Pair& lobe : kLobes) {
        const QuadratureResult found =
            integrate(lobe, kSchlickWeight, {}, places, Precision::float64, 1e-10);
        for (std::size_t i = 0; i < places.NoV.size(); ++i) {
            const auto truth = in_reference(lobe, places.alpha[i]);
            const double E = truth_of(truth, places.NoV[i]);
            // Charlie's E grows like 1 / NoV towards grazing views: 1e-9 of that.
            const double unit = 1e-9 * std::max(1.0, E);
            EXPECT_NEAR(found.E[i], E, 2 * unit) << text(lobe, places, i);
            EXPECT_NEAR(found.B[i], truth_of(truth, places.NoV[i], schlick), 2 * unit)
                << text(lobe, places, i);
        }
    }
}

// Where the reference does not go: two orders agree within what is promised, down to alpha = 1e-4.
TEST_F(QuadratureOfLobes, SettlesOverTheWholeRange) {
    const Places places({1e-4, 1e-3, 0.01, 0.1, 0.5, 1.0}, {1e-4, 1e-3, 0.01, 0.1, 0.5, 1.0});
    for (const Pair& lobe : kLobes) {
        const QuadratureResult found =
            integrate(lobe, kSchlickWeight, {}, places, Precision::float64, 1e-9);
        EXPECT_TRUE(found.converged()) << lobe.distribution << " " << lobe.masking;
    }
}

// Beckmann's 1 - E keeps its digits: against the reference as far as that, which subtracts, can
// say.
TEST_F(QuadratureOfLobes, DeficitOfBeckmannIsThatOfTheReference) {
    const Places places({1e-3, 0.05, 0.3, 1.0}, {0.02, 0.1, 0.4, 1.0});
    for (const int masking : {0, 1}) {
        const Pair lobe{kBeckmann, masking};
        const QuadratureResult found =
            integrate(lobe, kNoFresnel, {}, places, Precision::float64, 1e-10);
        for (std::size_t i = 0; i < places.NoV.size(); ++i) {
            const auto truth = in_reference(lobe, places.alpha[i]);
            const double deficit = 1 - truth_of(truth, places.NoV[i]);
            EXPECT_NEAR(found.deficit[i], deficit, 1e-6 * deficit + 2e-11) << text(lobe, places, i);
            EXPECT_GE(found.deficit[i], 0) << text(lobe, places, i);
            EXPECT_EQ(found.E[i], 1 - found.deficit[i]);
        }
    }
}

QuadratureParameters inside(double ior) { return {(ior - 1) * (ior + 1), ior * ior, 1}; }

TEST_F(QuadratureOfLobes, ReflectTotallyAsTheReferenceDoes) {
    const Places places({1e-3, 0.1, 0.6, 0.74, 1.0}, {0.02, 0.3, 1.0});
    const Pair lobes[] = {{kGgx, 0}, {kGgx, 1}, {kGgx, 2}, {kBeckmann, 0}, {kCharlie, 6}};
    for (const double ior : {0.3, 1 / 1.5, 0.99})
        for (const Pair& lobe : lobes) {
            if (ior != 1 / 1.5 && lobe.distribution != kGgx) continue;
            const QuadratureResult found =
                integrate(lobe, kDielectric, inside(ior), places, Precision::float64, 1e-10);
            for (std::size_t i = 0; i < places.NoV.size(); ++i) {
                const double truth =
                    reference::microfacet_albedo(in_reference(lobe, places.alpha[i]), places.NoV[i],
                                                 reference::fresnel_dielectric(ior));
                EXPECT_NEAR(found.B[i], truth, 2e-9 * std::max(1.0, found.E[i]))
                    << text(lobe, places, i) << ", ior " << ior;
            }
        }
}

// GGX beneath both rules: the one for all lobes is made to serve Smith's maskings by total
// reflection, and its E and 1 - E are those of the rule that is theirs alone.
TEST_F(QuadratureOfLobes, AgreesWithTheRuleOfGgxWhereBothServe) {
    const Places places({0.0, 1e-4, 0.02, 0.5, 1.0}, {1e-4, 0.01, 0.3, 1.0});
    for (const int masking : {0, 1}) {
        const Pair lobe{kGgx, masking};
        const QuadratureResult both =
            integrate(lobe, kDielectric, inside(0.7), places, Precision::float64, 1e-10);
        for (std::size_t i = 0; i < places.NoV.size(); ++i) {
            const double deficit =
                quadrature_deficit(places.NoV[i], places.alpha[i], static_cast<Masking>(masking));
            EXPECT_NEAR(both.deficit[i], deficit, 1e-6 * deficit) << text(lobe, places, i);
        }
    }
}

// Mirrors, and the ends of every range: what is 0, 1 or finite stays so, in both precisions.
TEST_F(QuadratureOfLobes, HasTheLimits) {
    const Places mirrors({0.0, 1e-6, 0.3, 1.0}, {0.0});
    for (const Pair& lobe :
         {Pair{kGgx, 2}, Pair{kGgx, 4}, Pair{kBeckmann, 0}, Pair{kBeckmann, 1}}) {
        const auto found = integrate(lobe, kSchlickWeight, {}, mirrors, Precision::float64, 1e-9);
        for (std::size_t i = 0; i < 4; ++i) {
            EXPECT_NEAR(found.E[i], 1, 4e-16) << text(lobe, mirrors, i);
            EXPECT_NEAR(found.B[i], std::pow(1 - mirrors.NoV[i], 5), 1e-15);
        }
    }
    // G1^2 of Schlick's form with k = 1/8.
    const auto direct = integrate({kGgx, 3}, kNoFresnel, {}, mirrors, Precision::float64, 1e-9);
    EXPECT_NEAR(direct.E[2], std::pow(0.3 / (0.3 * 0.875 + 0.125), 2), 1e-15);
    // Normals of a Charlie of no width lie along the horizon: they send light down, and a view
    // along it sees them without bound, so the job that asks for it fails.
    EXPECT_THROW(integrate({kCharlie, 5}, kNoFresnel, {}, mirrors, Precision::float64, 1e-9),
                 std::exception);
    for (const int masking : {5, 6, 7}) {
        const Places above({1e-6, 0.3, 1.0}, {0.0});
        const auto none =
            integrate({kCharlie, masking}, kSchlickWeight, {}, above, Precision::float32, 1e-9);
        for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(none.E[i] + none.B[i], 0);
    }
    const Places ends({0.0, 1e-30, 1e-6, 0.5, 1.0}, {1e-30, 1e-12, 1e-6, 0.5, 1.0});
    for (const Precision precision : {Precision::float32, Precision::float64})
        for (const Pair& lobe : {Pair{kGgx, 0}, Pair{kGgx, 2}, Pair{kGgx, 4}, Pair{kBeckmann, 1}}) {
            const auto found = integrate(lobe, kDielectric, inside(0.5), ends, precision, 1e-6);
            for (std::size_t i = 0; i < ends.NoV.size(); ++i) {
                EXPECT_TRUE(found.E[i] >= 0 && found.E[i] <= 1 + 1e-6) << text(lobe, ends, i);
                EXPECT_TRUE(found.B[i] >= -1e-6 && found.B[i] <= found.E[i] + 1e-6)
                    << text(lobe, ends, i);
            }
        }
}

// On float inputs; Charlie's alone may be off by more, which is why jobs integrate it in double.
TEST_F(QuadratureOfLobes, FloatIsWithinItsRoundingOfDouble) {
    Places places({1e-4, 1e-3, 0.02, 0.3, 0.9, 1.0}, {1e-4, 1e-3, 0.02, 0.25, 1.0});
    for (double& x : places.NoV) x = static_cast<float>(x);
    for (double& x : places.alpha) x = static_cast<float>(x);
    for (const Pair& lobe : kLobes)
        for (const bool total : {false, true}) {
            const int fresnel = total ? kDielectric : kSchlickWeight;
            QuadratureParameters p = total ? inside(0.75) : QuadratureParameters{};
            const auto single = integrate(lobe, fresnel, p, places, Precision::float32, 1e-6);
            const auto wide = integrate(lobe, fresnel, p, places, Precision::float64, 1e-10);
            const double rounding = is_charlie_fit(lobe.masking) ? 3e-6 : 1e-6;
            EXPECT_LE(rounding, quadrature_float_rounding(quadrature_kind(material(lobe), fresnel,
                                                                          p, Precision::float32)));
            for (std::size_t i = 0; i < places.NoV.size(); ++i) {
                const double unit = rounding * std::max(1.0, wide.E[i]);
                EXPECT_NEAR(single.E[i], wide.E[i], unit) << text(lobe, places, i) << total;
                EXPECT_NEAR(single.B[i], wide.B[i], unit) << text(lobe, places, i) << total;
            }
        }
}

// Squares of these cosines are no numbers in float: B was none at 2e-23 to 1e-20. Charlie's own
// masking, infinite at NoV = 0, is integrated in double.
TEST_F(QuadratureOfLobes, FloatHoldsAtViewsAlongTheSurface) {
    Places places({1e-24, 2e-23, 2e-22, 3e-21, 1e-20, 1e-19, 1e-18, 3e-18, 1e-12},
                  {1e-4, 1e-3, 0.02, 0.25, 1.0});
    for (double& x : places.NoV) x = static_cast<float>(x);
    for (double& x : places.alpha) x = static_cast<float>(x);
    for (const Pair& lobe : kLobes) {
        if (is_charlie_fit(lobe.masking)) continue;
        const auto single = integrate(lobe, kSchlickWeight, {}, places, Precision::float32, 1e-6);
        const auto wide = integrate(lobe, kSchlickWeight, {}, places, Precision::float64, 1e-10);
        for (std::size_t i = 0; i < places.NoV.size(); ++i) {
            const double unit = 1e-6 * std::max(1.0, wide.E[i]);
            EXPECT_NEAR(single.E[i], wide.E[i], unit) << text(lobe, places, i);
            EXPECT_NEAR(single.B[i], wide.B[i], unit) << text(lobe, places, i);
        }
    }
}

// The reference's averages are good to 1e-8.
TEST_F(QuadratureOfLobes, AveragesAreThoseOfTheReference) {
    for (const Pair& lobe : {Pair{kGgx, 4}, Pair{kBeckmann, 0}, Pair{kCharlie, 6}}) {
        const auto deficits =
            quadrature_averages(*backend_, quadrature_average_kind(material(lobe)), {},
                                std::array{0.36}, 1e-9, [] {})
                .mean;
        EXPECT_NEAR(1 - deficits[0], reference::microfacet_average(in_reference(lobe, 0.36)), 2e-8)
            << lobe.distribution << " " << lobe.masking;
    }
}

}  // namespace
}  // namespace kiln
