// SPDX-License-Identifier: Apache-2.0
// The quadrature beside the one of tests/reference, which shares no variable and no line with it.
#include "server/compute/quadrature.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>
#include <string>

#include "server/compute/native.h"
#include "server/compute/opencl.h"
#include "tests/compute/every_lobe.h"
#include "tests/reference/reference.h"

namespace kiln {
namespace {

constexpr int kFresnelModels = 6;  // KILN_FRESNEL_NONE to _F82_TINT
constexpr int kDielectric = 3;
constexpr Masking kMaskings[] = {Masking::smith_correlated, Masking::smith_separable};

reference::Masking in_reference(Masking masking) {
    return masking == Masking::smith_correlated ? reference::Masking::correlated
                                                : reference::Masking::separable;
}

struct Place {
    double NoV, alpha;
};

/// 8 NoV x 9 alpha from 1e-4 to 1.
std::vector<Place> grid() {
    std::vector<Place> places;
    for (const double NoV : {1e-4, 1e-3, 0.01, 0.1, 0.3, 0.5, 0.8, 1.0})
        for (const double alpha : {1e-4, 1e-3, 0.01, 0.03, 0.1, 0.25, 0.5, 0.8, 1.0})
            places.push_back({NoV, alpha});
    return places;
}

/// Off the grid: logarithmic in both, and every third close to the normal.
std::vector<Place> random_places(std::size_t count) {
    std::mt19937_64 random(11);
    std::uniform_real_distribution<double> exponent(-4, 0);
    std::vector<Place> places(count);
    for (std::size_t i = 0; i < count; ++i) {
        const double x = std::pow(10, exponent(random));
        places[i] = {i % 3 == 0 ? std::max(1e-4, 1 - x) : x, std::pow(10, exponent(random))};
    }
    return places;
}

void expect_exact(const Place& at, Masking masking) {
    SCOPED_TRACE(testing::Message()
                 << at.NoV << " " << at.alpha << " " << static_cast<int>(masking));
    const QuadratureValue value = quadrature_albedo(at.NoV, at.alpha, masking);
    const reference::Masking truth = in_reference(masking);
    const double E = reference::directional_albedo(at.NoV, at.alpha, truth);
    const double B = reference::split_sum(at.NoV, at.alpha, truth).bias;
    // The promise; and the stated error, doubled since two orders may agree by chance, beside the
    // reference's own 1e-12.
    EXPECT_NEAR(value.E, E, 1e-9);
    EXPECT_NEAR(value.B, B, 1e-9);
    EXPECT_NEAR(value.E, E, 2 * value.error + 2e-12);
    EXPECT_NEAR(value.B, B, 2 * value.error + 2e-12);
    const double deficit = reference::deficit(at.NoV, at.alpha, truth);
    EXPECT_NEAR(value.deficit / deficit, 1, 1e-6);
    EXPECT_DOUBLE_EQ(value.E + value.deficit, 1);
    EXPECT_NEAR(quadrature_directional_albedo(at.NoV, at.alpha, masking), E, 1e-9);
    EXPECT_NEAR(quadrature_deficit(at.NoV, at.alpha, masking) / deficit, 1, 1e-6);
}

TEST(Quadrature, HoldsItsPromiseOnTheGrid) {
    for (const Masking masking : kMaskings)
        for (const Place& at : grid()) expect_exact(at, masking);
}

TEST(Quadrature, HoldsItsPromiseOffTheGrid) {
    for (const Masking masking : kMaskings)
        for (const Place& at : random_places(200)) expect_exact(at, masking);
}

TEST(Quadrature, MeetsPublishedValues) {
    const Masking correlated = Masking::smith_correlated, separable = Masking::smith_separable;
    EXPECT_NEAR(quadrature_directional_albedo(0.01, 0.01, correlated), 0.891987352354539, 1e-12);
    EXPECT_NEAR(quadrature_directional_albedo(0.1, 0.25, correlated), 0.8916223518094879, 1e-12);
    EXPECT_NEAR(quadrature_directional_albedo(0.01, 0.1, separable), 0.9196002966549326, 1e-12);
    // alpha = 1 in closed form: 1 - NoV ln(1 + 1/NoV), and 2 (1 - ln 2) / (1 + NoV)
    for (const double NoV : {0.01, 0.3, 1.0}) {
        EXPECT_NEAR(quadrature_directional_albedo(NoV, 1, correlated),
                    1 - NoV * std::log1p(1 / NoV), 1e-12);
        EXPECT_NEAR(quadrature_directional_albedo(NoV, 1, separable),
                    2 * (1 - std::log(2)) / (1 + NoV), 1e-12);
    }
    EXPECT_NEAR(quadrature_albedo(0.1, 0.25, correlated).B, 0.13969245101640185, 1e-10);
    EXPECT_NEAR(quadrature_albedo(0.5, 0.1, correlated).B, 0.03213905559677277, 1e-10);
    EXPECT_NEAR(quadrature_albedo(1, 0.25, correlated).B, 2.7370926425609045e-05, 1e-10);
}

TEST(Quadrature, HasTheLimits) {
    for (const Masking masking : kMaskings)
        for (const double NoV : {0.0, 1e-4, 0.3, 1.0}) {
            const QuadratureValue mirror = quadrature_albedo(NoV, 0, masking);
            EXPECT_EQ(mirror.E, 1);
            EXPECT_EQ(mirror.deficit, 0);
            EXPECT_DOUBLE_EQ(mirror.B, std::pow(1 - NoV, 5));
        }
    for (const double alpha : {1e-4, 0.01, 0.25, 1.0}) {
        EXPECT_EQ(quadrature_albedo(0, alpha, Masking::smith_correlated).E, 1);
        EXPECT_NEAR(quadrature_albedo(0, alpha, Masking::smith_separable).E,
                    reference::directional_albedo(0, alpha, reference::Masking::separable), 1e-9);
    }
}

TEST(Quadrature, StaysInRangeAtExtremes) {
    const double ends[] = {0, 1e-300, 1e-30, 1e-12, 1e-8, 1e-6, 1e-3, 0.5, 1 - 1e-16, 1};
    for (const Masking masking : kMaskings)
        for (const double NoV : ends)
            for (const double alpha : ends) {
                const QuadratureValue value = quadrature_albedo(NoV, alpha, masking);
                EXPECT_TRUE(value.E >= 0.3 && value.E <= 1) << NoV << " " << alpha;
                EXPECT_TRUE(value.deficit >= 0 && value.deficit <= 0.7) << NoV << " " << alpha;
                EXPECT_TRUE(value.B >= 0 && value.B <= value.E) << NoV << " " << alpha;
            }
}

TEST(Quadrature, AveragesAreThoseOfTheReference) {
    ThreadPool pool(1);
    const auto backend = make_native_backend(pool, usable_instruction_sets().front());
    const std::vector<double> alphas = {0, 1e-4, 0.01, 0.1, 0.25, 1.0};
    for (const Masking masking : kMaskings) {
        const KernelMaterial lobe{.masking = static_cast<int>(masking)};
        const auto deficits =
            quadrature_averages(*backend, quadrature_average_kind(lobe), {}, alphas, 1e-9, [] {
            }).mean;
        ASSERT_EQ(deficits.size(), alphas.size());
        EXPECT_EQ(deficits[0], 0);
        for (std::size_t i = 1; i < alphas.size(); ++i) {
            const double deficit = reference::average_deficit(alphas[i], in_reference(masking));
            EXPECT_NEAR(deficits[i] / deficit, 1, 1e-6) << alphas[i];
            EXPECT_NEAR(1 - deficits[i],
                        reference::average_albedo(alphas[i], in_reference(masking)), 1e-9);
        }
        if (masking == Masking::smith_correlated) {
            EXPECT_NEAR(1 - deficits.back(), 4 * (1 - std::log(2)) / 3, 1e-10);
        }
    }
}

TEST(Quadrature, NodesAreGaussLegendres) {
    for (const auto& [order, error] : kQuadratureSteps) {
        const unsigned n = order.elevation / 2;
        ASSERT_EQ(quadrature_nodes({}, order).size(), 2 * (3 * n + order.azimuth));
        const std::vector<double> nodes = gauss_legendre({n});
        // The rule of n nodes is exact up to degree 2n - 1, and not beyond.
        for (const unsigned degree : {0u, 1u, 2 * n - 1, 2 * n}) {
            double sum = 0;
            for (std::size_t i = 0; i < n; ++i)
                sum += nodes[2 * i + 1] * std::pow(nodes[2 * i], degree);
            const double off = std::abs(sum - 1.0 / (degree + 1));
            if (degree < 2 * n) {
                EXPECT_LE(off, 1e-15) << n << " " << degree;
            } else if (n < 12) {  // with more nodes the difference is below rounding
                EXPECT_GT(off, 1e-15) << n;
            }
        }
    }
}

/// A request over both lists of places and the ends of both parameters, as float holds them.
struct Request {
    std::vector<double> NoV, alpha;
    Request() {
        std::vector<Place> places = random_places(200);
        for (const Place& at : grid()) places.push_back(at);
        for (const double end : {0.0, 1e-6, 1.0})
            for (const double other : {0.0, 1e-6, 0.3, 1.0}) places.push_back({end, other});
        for (const Place& at : places) {
            NoV.push_back(static_cast<float>(at.NoV));
            alpha.push_back(static_cast<float>(at.alpha));
        }
    }
};

TEST(QuadratureOnNative, FloatIsWithin1e6OfDouble) {
    ThreadPool pool(2);
    const auto backend = make_native_backend(pool, usable_instruction_sets().front());
    const Request request;
    for (const Masking masking : kMaskings) {
        const auto narrow = integrate_quadrature(*backend, {SmithRule{masking, kSchlickWeight}},
                                                 {request.NoV, request.alpha, {}}, {1e-6, 0});
        EXPECT_TRUE(narrow.converged());
        for (std::size_t i = 0; i < request.NoV.size(); ++i) {
            SCOPED_TRACE(testing::Message() << request.NoV[i] << " " << request.alpha[i]);
            const auto wide = quadrature_albedo(request.NoV[i], request.alpha[i], masking);
            EXPECT_NEAR(narrow.E[i], wide.E, 1e-6);
            EXPECT_NEAR(narrow.B[i], wide.B, 1e-6);
            EXPECT_NEAR(narrow.deficit[i], wide.deficit, 1e-6);
        }
    }
}

// Two low orders that agree there by chance may be off by 3e-5, at one of some hundred places.
TEST(QuadratureOnNative, FloatIsWithin1e6OfDoubleAtGrazingViews) {
    ThreadPool pool(2);
    const auto backend = make_native_backend(pool, usable_instruction_sets().front());
    constexpr int kSide = 100;
    std::vector<double> NoV, alpha;
    for (int i = 0; i < kSide; ++i)
        for (int j = 0; j < kSide; ++j) {
            NoV.push_back(static_cast<float>(1e-4 * std::pow(40, (i + 0.3) / kSide)));
            alpha.push_back(static_cast<float>(1e-4 * std::pow(1e4, (j + 0.6) / kSide)));
        }
    for (const Masking masking : kMaskings) {
        const SmithRule rule{masking, kSchlickWeight};
        const auto narrow =
            integrate_quadrature(*backend, {rule, Precision::float32}, {NoV, alpha, {}}, {1e-6, 0});
        const auto wide =
            integrate_quadrature(*backend, {rule, Precision::float64}, {NoV, alpha, {}}, {1e-9, 0});
        for (std::size_t i = 0; i < NoV.size(); ++i) {
            SCOPED_TRACE(testing::Message() << NoV[i] << " " << alpha[i]);
            EXPECT_NEAR(narrow.E[i], wide.E[i], 1e-6);
            EXPECT_NEAR(narrow.B[i], wide.B[i], 1e-6);
        }
    }
}

TEST(QuadratureOnNative, DoubleSettlesEveryTexelAtTheOrderThatItNeeds) {
    ThreadPool pool(2);
    const auto backend = make_native_backend(pool, usable_instruction_sets().front());
    const Request request;
    const Masking masking = Masking::smith_separable;
    const QuadratureKind kind{SmithRule{masking, kSchlickWeight}, Precision::float64};
    const auto result =
        integrate_quadrature(*backend, kind, {request.NoV, request.alpha, {}}, {1e-10, 1e-7});
    EXPECT_TRUE(result.converged());
    for (std::size_t i = 0; i < request.NoV.size(); ++i) {
        const auto wide = quadrature_albedo(request.NoV[i], request.alpha[i], masking);
        EXPECT_NEAR(result.E[i], wide.E, 1e-9);
        EXPECT_NEAR(result.B[i], wide.B, 1e-9);
    }
    // Were all texels taken to the highest order that one of them needs, it would cost more.
    std::uint64_t all = 0;
    for (const auto& [order, error] : kQuadratureSteps)
        if (order.azimuth <= result.order_max.azimuth) all += quadrature_evaluations(kind, order);
    EXPECT_LT(result.evaluations, all * request.NoV.size() / 2);
    const auto hopeless =
        integrate_quadrature(*backend, kind, {request.NoV, request.alpha, {}}, {1e-30, 0});
    EXPECT_FALSE(hopeless.converged());
    EXPECT_EQ(hopeless.order_max.azimuth, std::rbegin(kQuadratureSteps)->order.azimuth);
}

template <typename Scalar>
std::vector<Scalar> values(Backend& backend, const QuadratureKind& kind) {
    const Request request;
    constexpr QuadratureOrder kOrder{20, 24};
    const std::size_t stride = (request.NoV.size() + kLanesMax - 1) / kLanesMax * kLanesMax;
    std::vector<Scalar> texels(2 * stride, Scalar(0.5));
    for (std::size_t i = 0; i < request.NoV.size(); ++i) {
        texels[i] = static_cast<Scalar>(request.NoV[i]);
        texels[stride + i] = static_cast<Scalar>(request.alpha[i]);
    }
    const std::vector<double> rule = quadrature_nodes(kind, kOrder);
    const std::vector<Scalar> nodes(rule.begin(), rule.end());
    std::vector<Scalar> out(quadrature_planes(kind) * stride);
    const QuadratureParameters numbers = any_quadrature_parameters(kind);
    const std::vector<Scalar> parameters(numbers.begin(), numbers.end());
    backend.run(QuadratureLaunch<Scalar>{kind, stride, texels, nodes, parameters, kOrder, out});
    return out;
}

template <typename Scalar>
void expect_same_bits(Backend& a, Backend& b, const QuadratureKind& kind) {
    const auto mine = values<Scalar>(a, kind), other = values<Scalar>(b, kind);
    EXPECT_EQ(std::memcmp(mine.data(), other.data(), mine.size() * sizeof(Scalar)), 0)
        << "rule " << kind.rule.index() << ", Fresnel " << fresnel_of(kind);
}

/// GGX under Smith's maskings under every Fresnel term; those of all other lobes in turn, and total
/// reflection.
std::vector<QuadratureKind> kinds() {
    std::vector<QuadratureKind> list;
    for (const Precision precision : {Precision::float32, Precision::float64}) {
        for (const Masking masking : kMaskings)
            for (int fresnel = 0; fresnel < kFresnelModels; ++fresnel)
                list.push_back({SmithRule{masking, fresnel}, precision});
        // ggx_lambert walks, and has no rule.
        for (int model = 0; model < KILN_DIFFUSE_GGX_LAMBERT; ++model)
            list.push_back({DiffuseRule{model, model % kFresnelModels}, precision});
    }
    // Of the rule for every lobe, in turn, to spare compilers: precision changes no line of it.
    int turn = 0;
    const auto precision = [&] { return turn % 2 == 0 ? Precision::float32 : Precision::float64; };
    const std::vector<LobePair> lobes = lobes_of_the_general_rule();
    for (const auto& [distribution, masking] : lobes) {
        list.push_back({LobeRule{distribution, masking, turn % kFresnelModels}, precision()});
        ++turn;
    }
    for (const std::size_t i : {0, 3, 6, 1}) {
        list.push_back(
            {LobeRule{lobes[i].distribution, lobes[i].masking, kDielectric, true}, precision()});
        ++turn;
    }
    return list;
}

void expect_same_bits(Backend& a, Backend& b, const QuadratureKind& kind) {
    if (kind.precision == Precision::float64)
        expect_same_bits<double>(a, b, kind);
    else
        expect_same_bits<float>(a, b, kind);
}

TEST(QuadratureOnNative, EveryInstructionSetAndThreadCountGivesTheSameBits) {
    ThreadPool one(1), three(3);
    const auto sets = usable_instruction_sets();
    const auto first = make_native_backend(one, sets.front());
    for (const InstructionSet set : sets)
        for (const QuadratureKind& kind : kinds())
            expect_same_bits(*first, *make_native_backend(three, set), kind);
}

TEST(QuadratureOnOpenCl, GivesTheBitsOfNative) {
    ThreadPool pool(1);
    const auto native = make_native_backend(pool, usable_instruction_sets().front());
    std::unique_ptr<OpenClBackend> device;
    try {
        device = std::make_unique<OpenClBackend>(*native);
    } catch (const std::exception& error) {
        GTEST_SKIP() << "no OpenCL device on this machine: " << error.what();
    }
    for (const QuadratureKind& kind : kinds()) {
        EXPECT_FALSE(device->built(kind));
        device->build(kind);
        // Of PoCL on a CPU equal bits are promised, so another class there is a failure.
        const std::string name = device->name();
        if (name.starts_with("pthread-") || name.starts_with("cpu-"))
            ASSERT_EQ(device->numerics(kind), kStrictNumerics) << name;
        else if (device->numerics(kind) != kStrictNumerics)
            GTEST_SKIP() << name << " is no CPU and rounds in its own way";
        expect_same_bits(*native, *device, kind);
    }
}

}  // namespace
}  // namespace kiln
