// SPDX-License-Identifier: Apache-2.0
// Samples a second of every kernel specialisation on both backends: a 64 × 64 table, 1024 samples a
// texel.
//
// The arithmetic limit of the split sum (visible normals, correlated Smith, float), counted for one
// sample of one lane group: 2 √ (the cap's sine, the light's Smith length) and 1 ÷ (G2 / G1) on the
// divider; 20 products, sums, fused products and selections for E, 20 more for B (the reciprocal
// root, Schlick, the sum). On a core with a 16-lane √ every 4.8 ns, ÷ every 3.9 ns and one such
// operation every 0.23 ns (measured), E is bound by the divider at 13.5 ns, A and B by the
// same 13.5 ns as long as the other 40 operations (9.2 ns, and 2.1 ns for the divider's own) run
// beside it: 1.2 G samples/s a core.
//
// Of the quadrature, one node of the azimuth: 2 / (the map's scale, the lobe's ratio) and 43
// products, sums, fused products and selections (6 for the map, 5 for the weight, 8 for the lobe,
// 18 for the root of VoH, 6 for Schlick's weight): 9.9 ns, with the 7.8 ns of the divider beside
// them. One node of the elevation before them: 8 / and 4 roots, 50 ns.
#include <benchmark/benchmark.h>

#include <map>
#include <memory>
#include <string>

#include "server/base/error.h"
#include "server/compute/native.h"
#include "server/compute/opencl.h"
#include "server/compute/opencl_threads.h"
#include "server/compute/quadrature.h"

namespace {

using namespace kiln;

constexpr std::size_t kSide = 64, kStride = kSide * kSide, kSamples = 1024;

template <typename Scalar>
void run(benchmark::State& state, Backend& backend, const Specialisation& what) {
    std::vector<Scalar> texels(2 * kStride);
    for (std::size_t i = 0; i < kStride; ++i) {
        texels[i] = static_cast<Scalar>((static_cast<double>(i % kSide) + 0.5) / kSide);
        const double roughness = (static_cast<double>(i / kSide) + 0.5) / kSide;
        texels[kStride + i] = static_cast<Scalar>(roughness * roughness);
    }
    const PointSet set = make_points(Sampler::sobol_owen, point_kind(what.material), 0, kSamples);
    const std::vector<Scalar> points(set.values.begin(), set.values.end());
    const auto parameters = any_parameters<Scalar>();
    std::vector<Scalar> sums(
        set.batches.size() *
        static_cast<std::size_t>(__builtin_popcount(static_cast<unsigned>(what.material.terms))) *
        kStride);
    for (auto _ : state) {
        backend.run(Launch<Scalar>{what, kStride, texels, points, parameters, set.batches, sums});
        benchmark::DoNotOptimize(sums.data());
    }
    state.counters["samples/s"] = benchmark::Counter(static_cast<double>(kStride * kSamples),
                                                     benchmark::Counter::kIsIterationInvariantRate);
}

/// One order over the same table; counts nodes.
template <typename Scalar>
void run(benchmark::State& state, Backend& backend, const QuadratureKind& what) {
    constexpr QuadratureOrder kOrder{14, 14};
    std::vector<Scalar> texels(2 * kStride);
    for (std::size_t i = 0; i < kStride; ++i) {
        texels[i] = static_cast<Scalar>((static_cast<double>(i % kSide) + 0.5) / kSide);
        const double roughness = (static_cast<double>(i / kSide) + 0.5) / kSide;
        texels[kStride + i] = static_cast<Scalar>(roughness * roughness);
    }
    const std::vector<double> rule = quadrature_nodes(kOrder);
    const std::vector<Scalar> nodes(rule.begin(), rule.end());
    const auto parameters = any_parameters<Scalar>();
    std::vector<Scalar> values(quadrature_planes(what) * kStride);
    for (auto _ : state) {
        backend.run(QuadratureLaunch<Scalar>{
            what, kStride, texels, nodes,
            std::span<const Scalar>(parameters).first(kFresnelParameters), kOrder, values});
        benchmark::DoNotOptimize(values.data());
    }
    const bool fresnel = what.fresnel != kNoFresnel;
    state.counters["nodes/s"] =
        benchmark::Counter(static_cast<double>(kStride * quadrature_evaluations(kOrder, fresnel)),
                           benchmark::Counter::kIsIterationInvariantRate);
}

template <typename What>
void add(const std::string& name, Backend& backend, const What& what) {
    benchmark::RegisterBenchmark(name.c_str(),
                                 [&backend, what](benchmark::State& state) {
                                     if (what.precision == Precision::float64)
                                         run<double>(state, backend, what);
                                     else
                                         run<float>(state, backend, what);
                                 })
        ->UseRealTime()
        ->Unit(benchmark::kMillisecond);
}

const std::map<std::string, QuadratureKind> kQuadratures = {
    {"quadrature_E", {}},
    {"quadrature_B", {.fresnel = kSchlickWeight}},
    {"quadrature_dielectric", {.fresnel = 3}},
    {"quadrature_B_float64", {.fresnel = kSchlickWeight, .precision = Precision::float64}},
};

const std::map<std::string, Specialisation> kCases = {
    {"E", {{.terms = 1}}},
    {"A_B", {{.terms = 3}}},
    {"A_B_multiscatter", {{.terms = 7}}},
    {"multiscatter", {{.terms = 4}}},
    {"E_separable", {{.masking = 1, .terms = 1}}},
    {"A_B_ndf", {{.importance = 1, .terms = 3}}},
    {"E_avg", {{.terms = 1, .averaged = 1}}},
    {"A_B_float64", {{.terms = 3}, Precision::float64}},
    // The general path (kernels/material.h), by the numbers of kernels/*.h.
    {"schlick", {{.terms = 8, .fresnel = 1, .general = 1}}},
    {"dielectric", {{.terms = 8, .fresnel = 3, .general = 1}}},
    {"conductor_RGB", {{.terms = 56, .fresnel = 4, .general = 1}}},
    {"f82_tint_RGB", {{.terms = 56, .fresnel = 5, .general = 1}}},
    {"karis_ibl", {{.masking = 2, .terms = 1, .general = 1}}},
    {"unreal_joint", {{.masking = 4, .terms = 1, .general = 1}}},
    {"beckmann", {{.distribution = 1, .importance = 1, .terms = 1, .general = 1}}},
    {"charlie_neubelt",
     {{.distribution = 2, .masking = 5, .importance = 3, .terms = 1, .general = 1}}},
    {"charlie", {{.distribution = 2, .masking = 6, .importance = 3, .terms = 1, .general = 1}}},
    {"lambert", {{.importance = 2, .terms = 64, .diffuse = 0, .general = 1}}},
    {"burley", {{.importance = 2, .terms = 64, .diffuse = 1, .general = 1}}},
    {"oren_nayar", {{.importance = 2, .terms = 64, .diffuse = 2, .general = 1}}},
    {"oren_nayar_full", {{.importance = 2, .terms = 64, .diffuse = 3, .general = 1}}},
    {"fon", {{.importance = 2, .terms = 64, .diffuse = 4, .general = 1}}},
    {"eon", {{.importance = 2, .terms = 64, .diffuse = 5, .general = 1}}},
    {"eon_unreal", {{.importance = 2, .terms = 64, .diffuse = 6, .general = 1}}},
    {"chan2018", {{.importance = 2, .terms = 64, .diffuse = 7, .general = 1}}},
    {"chan2024", {{.importance = 2, .terms = 64, .diffuse = 8, .general = 1}}},
};

}  // namespace

int main(int argc, char** argv) {
    pin_opencl_threads();
    ThreadPool one(1), all(0);
    std::vector<std::unique_ptr<Backend>> backends;
    for (const InstructionSet set : usable_instruction_sets()) {
        backends.push_back(make_native_backend(one, set));
        add("native/" + to_string(set) + "/one_thread/A_B", *backends.back(), kCases.at("A_B"));
    }
    backends.push_back(make_native_backend(all, usable_instruction_sets().front()));
    for (const auto& [name, what] : kCases)
        add("native/all_threads/" + name, *backends.back(), what);
    for (const auto& [name, what] : kQuadratures) {
        add("native/one_thread/" + name, *backends.front(), what);
        add("native/all_threads/" + name, *backends.back(), what);
    }
    std::unique_ptr<OpenClBackend> opencl;
    try {
        opencl = std::make_unique<OpenClBackend>(*backends.front());
        for (const auto& [name, what] : kCases) {
            opencl->build(what);
            add("opencl/" + name, *opencl, what);
        }
        for (const auto& [name, what] : kQuadratures) {
            opencl->build(what);
            add("opencl/" + name, *opencl, what);
        }
    } catch (const Error& error) {
        std::fprintf(stderr, "no OpenCL: %s\n", error.what());
    }
    benchmark::Initialize(&argc, argv);
    benchmark::RunSpecifiedBenchmarks();
    return 0;
}
